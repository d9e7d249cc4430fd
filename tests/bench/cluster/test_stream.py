"""The bench of streams between gateways, as short as it can be: what it says is for a quiet machine."""

from openrois_bench.cluster.stream import DEPTH, StreamSettings, measure, printed, summary


async def test_it_measures_both_ways(nats: None) -> None:
    said: list[str] = []
    ways = await measure(StreamSettings(rounds=2, asked=10, piped=2 * DEPTH, large=2), said.append)
    assert said == ["round 1 of 2", "round 2 of 2"]
    figures = summary(ways)
    for name in ("WebSocket", "NATS"):
        assert figures[name]["asked"]["count"] == 20
        assert 0 < figures[name]["asked"]["p50"] <= figures[name]["asked"]["p99"]
        assert figures[name]["large"]["count"] == 4
        assert figures[name]["per_second"] > 0
    assert figures["ratio"] > 0
    assert "NATS / WebSocket" in printed(figures)
