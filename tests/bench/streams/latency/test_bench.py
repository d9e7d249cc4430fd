import asyncio
from pathlib import Path

import pytest
from openrois_bench.errors import BenchFailed
from openrois_bench.streams.latency.bench import LatencySettings, run_latency
from openrois_bench.viewing.observation import Observation

SHORT = LatencySettings(seconds=0.5, runs=1, sizes=((640, 360),))


def check(seen: Observation, viewer: str) -> None:
    assert (seen.viewer, seen.codec, seen.width, seen.height) == (viewer, "video/H264", 640, 360)
    assert seen.pictures >= 3
    assert seen.unreadable == 0
    for name, series in seen.milliseconds.items():
        assert 0 < series.p50 <= series.p95 < 5000, name


@pytest.mark.long
@pytest.mark.media
async def test_a_viewer_without_a_browser_measures_the_whole_path() -> None:
    told: list[str] = []
    async with asyncio.timeout(60):
        report = await run_latency(SHORT, told.append)
    assert told == ["640x360: sink"]
    assert (report.seconds, report.runs) == (0.5, 1)
    assert report.conditions.cpus >= 1
    (seen,) = report.observations
    check(seen, "sink")
    assert list(seen.milliseconds) == ["decoded", "connect", "resume"]
    assert seen.milliseconds["decoded"].count == seen.pictures
    assert seen.milliseconds["resume"].count == seen.milliseconds["connect"].count == 1


@pytest.mark.browser
@pytest.mark.long
async def test_a_viewer_in_chromium_measures_the_whole_path(chromium: Path) -> None:
    settings = LatencySettings(seconds=0.5, runs=1, sizes=((640, 360),), chromium=str(chromium))
    async with asyncio.timeout(58):
        report = await run_latency(settings, lambda _text: None)
    assert "Chromium" in report.conditions.versions
    _, seen = report.observations
    check(seen, "Chromium")
    assert list(seen.milliseconds) == ["received", "presented", "connect", "resume"]
    assert seen.milliseconds["received"].p50 < seen.milliseconds["presented"].p50
    assert seen.milliseconds["resume"].count == seen.milliseconds["connect"].count == 1


@pytest.mark.media
async def test_an_adapter_that_does_not_start_ends_the_bench() -> None:
    async with asyncio.timeout(60):
        with pytest.raises(BenchFailed, match=r"the adapter does not start: .*needed, not 3x3"):
            await run_latency(LatencySettings(sizes=((3, 3),)), lambda _text: None)
