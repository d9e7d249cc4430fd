"""The bench of gateways that are killed, as short as it can be: what it says is for a quiet machine."""

import pytest
from openrois_bench.cluster.failover import CASES, measure, printed, summary


@pytest.mark.usefixtures("nats", "postgres_programs")
@pytest.mark.long
async def test_it_measures_both_cases() -> None:
    said: list[str] = []
    figures = summary(await measure(2, said.append))
    assert said == ["round 1 of 2", "round 2 of 2"]
    for name in CASES:
        assert figures[name]["operated"]["count"] == figures[name]["attached"]["count"] == 1
        assert figures[name]["operated"]["p50"] > 0
        assert name in printed(figures)
