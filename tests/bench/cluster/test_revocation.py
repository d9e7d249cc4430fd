"""The bench of rights that are taken away, as short as it can be: what it says is for a quiet machine."""

import pytest
from openrois_bench.cluster.revocation import CASES, measure, printed, summary


@pytest.mark.usefixtures("nats", "postgres_programs")
@pytest.mark.long
async def test_it_measures_all_cases() -> None:
    said: list[str] = []
    figures = summary(await measure(1, said.append))
    assert said == ["round 1 of 1"]
    for name in CASES:
        assert figures[name]["held"]["count"] == 1
        assert figures[name]["held"]["p50"] > 0
        assert ("replied" in figures[name]) == name.startswith("STOP")
        assert name in printed(figures)
