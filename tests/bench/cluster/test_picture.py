"""The bench of a picture whose gateway is killed, as short as it can be: what it says is for a quiet machine."""

import pytest
from openrois_bench.cluster.picture import CASES, measure, printed, summary


@pytest.mark.usefixtures("nats", "postgres_programs")
@pytest.mark.media
@pytest.mark.long
async def test_it_measures_all_cases() -> None:
    said: list[str] = []
    figures = summary(await measure(2, said.append, watched=1.0))
    assert said == ["round 1 of 2", "round 2 of 2"]
    for name in CASES:
        assert figures[name]["before"]["count"] == figures[name]["after"]["count"] == 1
        assert figures[name]["longest"] > 0
        assert figures[name]["replaced"]["p50"] > 0
        assert name in printed(figures)
