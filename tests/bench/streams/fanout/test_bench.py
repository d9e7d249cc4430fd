import asyncio

import pytest
from openrois_bench.streams.fanout.bench import FanoutSettings, run_fanout
from openrois_bench.streams.fanout.runs import AIORTC, OPENROIS


@pytest.mark.media
@pytest.mark.long
async def test_both_ways_of_sending_are_measured_side_by_side() -> None:
    told: list[str] = []
    async with asyncio.timeout(58):
        report = await run_fanout(FanoutSettings(seconds=0.4, rounds=1, viewers=(1, 2)), told.append)
    assert told == ["connecting 2 viewers to each of 4 senders", "round 1 of 1"]
    assert [(each.codec, each.viewers) for each in report.comparisons] == [
        ("video/VP8", 1),
        ("video/VP8", 2),
        ("video/H264", 1),
        ("video/H264", 2),
    ]
    assert len(report.runs) == 8
    for run in report.runs:
        assert run.cpu > 0
        assert len(run.fps) == run.viewers
        assert min(run.fps) > 0
        assert run.kbps > 0
        assert run.others is None or run.others >= 0
        assert run.encoders == (1 if run.way == OPENROIS else run.viewers)
    assert {run.way for run in report.runs} == {OPENROIS, AIORTC}
