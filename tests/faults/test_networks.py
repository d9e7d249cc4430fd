"""F34 to F36: media over networks that lose, delay, disorder and throttle."""

import asyncio
from pathlib import Path

import pytest
from openrois_streaming.testing import Impairments

from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, MEDIA_PATIENCE, VIDEO
from tests.support.stage import stage

pytestmark = pytest.mark.media

BACK = Impairments(delay=0.01)
LOSSES = (0.05, 0.20, 0.01, 0.10)
FREEZE = 3.0
"""Seconds that a picture may stand at a loss of 5 %; on a machine that has time it takes less than one."""


@pytest.mark.parametrize("seed", lasting(0))
async def test_f34_losses_alone_and_in_bursts(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    loss, burst = LOSSES[seed % 4], (None, 3.0)[seed // 2 % 2]
    async with stage(seed, tmp_path, caplog) as on:
        app = await on.spectator()
        app.path = path = await on.path(Impairments(delay=0.01), BACK)
        video, audio = await app.play(VIDEO), await app.play(AUDIO)
        path.down.change(loss=loss, burst=burst)
        app.longest_gap = 0.0
        await app.sees(video, 80)
        await app.sees(audio, 20)
        # Where one packet in a hundred is lost, of few none may be.
        async with asyncio.timeout(MEDIA_PATIENCE):
            while not (await on.stream(video)).packets_retransmitted:
                await app.sees(video, 5)
        assert path.down.figures().lost > 0
        assert loss > 0.05 or app.longest_gap < FREEZE
        path.down.change(loss=0.0)
        await app.sees(video, 20)
        for stream_id in (video, audio):
            await app.is_now(stream_id, "RUNNING")
        assert app.byes == app.errors == []


@pytest.mark.parametrize("seed", lasting())
async def test_f35_late_disordered_and_doubled(seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        on.place.relay.change(delay=0.3, jitter=0.1)
        app = await on.spectator(relayed=True)
        bad = Impairments(delay=0.3, jitter=0.1, reorder=0.25, reorder_by=0.05, duplicate=0.1)
        app.path = path = await on.path(bad, bad)
        video, audio = await app.play(VIDEO), await app.play(AUDIO)
        await app.sees(video, 60)
        await app.sees(audio, 20)
        assert await app.becomes(VIDEO, "READY") == "READY"
        seen = await on.stream(video)
        assert seen.round_trip_time is not None
        assert seen.round_trip_time > 0.5
        figures = path.down.figures()
        assert figures.held_back > 0
        assert figures.duplicated > 0
        assert app.told == {stream_id: ["NOT_RUNNING", "RUNNING"] for stream_id in (video, audio)}
        assert app.byes == app.errors == []


@pytest.mark.parametrize("seed", lasting())
async def test_f36_bandwidth_that_collapses_and_returns(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog, size=(640, 360)) as on:
        app = await on.spectator()
        app.path = path = await on.path(Impairments(delay=0.01), BACK)
        video, audio = await app.play(VIDEO), await app.play(AUDIO)
        await app.sees(video, on.place.chance.randrange(5, 40))
        path.down.change(rate=150_000, queue=0.3)
        # Within some seconds all of it fits, so that nothing waits for ever; and the sound comes as before.
        await app.until(lambda: app.newest_size[video][1] <= 180)
        await app.sees(audio, 100)
        await app.sees(video, 5)
        assert await app.code("rois.system.get_profile", condition="") == "OK"
        path.down.change(rate=None)
        await app.until(lambda: app.newest_size[video][1] == 360)
        for stream_id in (video, audio):
            await app.is_now(stream_id, "RUNNING")
        assert app.byes == app.errors == []
