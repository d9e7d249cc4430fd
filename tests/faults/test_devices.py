"""F41: an application's camera and microphone that are pulled out, or busy, and come back."""

import asyncio
from pathlib import Path

import pytest
from aiortc import MediaStreamTrack
from av import AudioFrame, VideoFrame

from tests.support.black_box_media import Camera, Microphone
from tests.support.seeds import lasting
from tests.support.spectator import AUDIO, VIDEO
from tests.support.stage import stage

pytestmark = pytest.mark.media


class Plug:
    """Whether devices are plugged in."""

    def __init__(self, *, inside: bool) -> None:
        self.inside = asyncio.Event()
        if inside:
            self.inside.set()


class PluggedCamera(Camera):
    """A camera that gives pictures while it is plugged in."""

    def __init__(self, plug: Plug) -> None:
        super().__init__()
        self._plug = plug

    async def recv(self) -> VideoFrame:
        await self._plug.inside.wait()
        return await super().recv()


class PluggedMicrophone(Microphone):
    """A microphone that gives sound while it is plugged in."""

    def __init__(self, plug: Plug) -> None:
        super().__init__()
        self._plug = plug

    async def recv(self) -> AudioFrame:
        await self._plug.inside.wait()
        return await super().recv()


@pytest.mark.parametrize("seed", lasting(0))
async def test_f41_devices_that_are_pulled_out_and_busy(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with stage(seed, tmp_path, caplog) as on:
        chance = on.place.chance
        # Of a device that another program has nothing comes until that lets it go.
        plug, busy = Plug(inside=True), chance.random() < 0.5
        if busy:
            plug.inside.clear()
        app, other = await on.spectator(), await on.spectator()
        tracks: dict[str, MediaStreamTrack] = {"video": PluggedCamera(plug), "audio": PluggedMicrophone(plug)}
        app.devices = tracks
        seen = await other.play(VIDEO)
        camera, microphone = await app.send(VIDEO), await app.send(AUDIO)
        if busy:
            await app.is_now(camera, "NOT_RUNNING")
            plug.inside.set()
        for _ in range(2):
            for stream_id in (camera, microphone):
                await app.is_now(stream_id, "RUNNING")
            plug.inside.clear()
            for stream_id in (camera, microphone):
                await app.is_now(stream_id, "NOT_RUNNING")
            # What the avatar shows and what others see does not depend on it.
            await other.sees(seen)
            assert await other.becomes(VIDEO, "READY") == "READY"
            plug.inside.set()
        for stream_id in (camera, microphone):
            await app.is_now(stream_id, "RUNNING")
        assert app.byes == app.errors == other.byes == other.errors == []
        for track in tracks.values():
            track.stop()
