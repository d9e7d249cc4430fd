import asyncio

import pytest
from openrois_bench.faults.stop import StopSettings, run_stop

SMALL = StopSettings(seconds=1.0, dead_man=1, reports=1_000, strangers=500, viewers=2)


@pytest.mark.media
@pytest.mark.long
async def test_stop_and_the_dead_mans_switch_are_measured_beside_floods() -> None:
    told: list[str] = []
    async with asyncio.timeout(120):
        report = await run_stop(SMALL, told.append)
    assert told == ["STOP, idle", "STOP, authentic RTCP", "STOP, strangers", "STOP, both"]
    assert [run.load for run in report.runs] == list(SMALL.loads)
    for run in report.runs:
        assert run.unconfirmed == 0
        assert run.stops.count >= 1
        assert 0 < run.stops.p50 <= run.stops.p99
        assert len(run.dead_man) == 1
        assert run.adapter > 0
        assert bool(run.reports) is bool(run.load.reports)
        assert bool(run.strangers) is bool(run.load.strangers)
        assert run.joined + run.failed == run.load.viewers
