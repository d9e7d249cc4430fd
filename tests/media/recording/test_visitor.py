"""`openrois record --visitor`: what a visitor sends, as long as it consents to that, and nothing of after."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Generic, TypeVar

import av
import numpy as np
import pytest
from openrois_media.recording import record_command
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.testing import FaultRelay
from openrois.types.codes import Purpose
from tests.media.recording.test_commands import begin, finish, names
from tests.media.visitors.test_listening import Body, body, token, until
from tests.support.recordings import read_back

pytestmark = pytest.mark.media

__all__ = ["body"]

Item = TypeVar("Item", RawAudio, RawVideo)

LIVE, RECORDING = Purpose.LIVE, Purpose.RECORDING


class Scene:
    """A dark and quiet room, until it is made bright and loud."""

    def __init__(self) -> None:
        self.is_bright = False
        self.camera, self.microphone = _Device(self._picture, 1 / 15), _Device(self._block, 0.02)
        self._noise = np.random.default_rng(1).integers(-1, 2, (960, 1), np.int16)

    def _picture(self, at: float) -> RawVideo:
        data = np.full((120 * 3 // 2, 160), 128, np.uint8)
        data[:120] = 200 if self.is_bright else 60
        return RawVideo(data, "i420", 160, 120, 0, at)

    def _block(self, at: float) -> RawAudio:
        return RawAudio(self._noise * np.int16(20_000 if self.is_bright else 300), at)


class _Device(Generic[Item]):
    """A device that gives what is made for each moment."""

    def __init__(self, make: Callable[[float], Item], interval: float) -> None:
        self.given = 0
        self._make: Callable[[float], Item] = make
        self._interval = interval

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[Item]]:
        yield self._items()

    async def _items(self) -> AsyncIterator[Item]:
        clock = SystemClock()
        at = clock.now()
        while True:
            await clock.sleep_until(at)
            yield self._make(at)
            self.given += 1
            at += self._interval


@pytest.fixture
def listener_token(tmp_path: Path) -> Path:
    path = tmp_path / "listener.token"
    path.write_text(token("listener"))
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "films").mkdir()
    return tmp_path / "films"


@asynccontextmanager
async def recording(
    body: Body, path: Path, visitor: str, shown: Path, *more: str
) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run the command, until it has begun to record."""
    process = await begin("record", path, "--gateway", body.url, "--visitor", visitor, "--token-file", shown, *more)
    try:
        assert process.stderr is not None
        async with asyncio.timeout(60):
            while (line := await process.stderr.readline()) != b"openrois record: recording\n":
                assert line, "it has ended"
        yield process
    finally:
        if process.returncode is None:
            process.kill()


def brightest(path: Path) -> int:
    """Return the greatest mean luma of the pictures in a file."""
    with av.open(str(path), "r") as opened:
        return max(round(float(frame.to_ndarray(format="gray").mean())) for frame in opened.decode(video=0))


@pytest.mark.parametrize("how", ["withdrawn", "withdrawn and given again", "left"])
async def test_it_ends_with_the_consent_and_has_nothing_of_after(
    body: Body, folder: Path, listener_token: Path, how: str
) -> None:
    scene, path = Scene(), folder / "film.mp4"
    async with body.application("visitor") as sender, AsyncExitStack() as stay:
        sending = sender.send(camera=scene.camera, microphone=scene.microphone, consent=[LIVE, RECORDING])
        sent = await stay.enter_async_context(sending)
        (visitor,) = await sender.visitors("robot", purposes=[RECORDING])
        async with recording(body, path, visitor.visitor_ref, listener_token) as process:
            heard = scene.microphone.given
            await until(lambda: scene.microphone.given >= heard + 50)
            if how == "left":
                await stay.aclose()
            else:
                await sent.consent(LIVE)
                scene.is_bright = True
            if how == "withdrawn and given again":
                await sent.consent(LIVE, RECORDING)
            status, said = await finish(process)
    assert status == 0, said
    assert "the visitor has left, or does not consent to be recorded any more" in said
    assert names(folder) == ["film.mp4"]
    recorded = read_back(path)
    assert set(recorded.codecs) == {"video", "audio"}
    assert recorded.pictures
    assert brightest(path) < 100
    assert np.abs(recorded.sound).max(initial=0) < 0.1


async def test_it_ends_where_the_visitor_has_left_while_the_gateway_was_away(
    body: Body, folder: Path, listener_token: Path
) -> None:
    scene, path = Scene(), folder / "film.webm"
    async with (
        FaultRelay(body.url) as relay,
        body.application("visitor") as sender,
        AsyncExitStack() as stay,
    ):
        sending = sender.send(microphone=scene.microphone, consent=[RECORDING])
        await stay.enter_async_context(sending)
        (visitor,) = await sender.visitors("robot", purposes=[RECORDING])
        async with recording(replace(body, url=relay.url), path, visitor.visitor_ref, listener_token) as process:
            relay.cut(refuse=True)
            await stay.aclose()
            relay.mend()
            status, said = await finish(process)
    assert status == 0, said
    assert "the visitor has left" in said
    assert names(folder) == ["film.webm"]


async def test_a_visitor_that_does_not_consent_to_that_is_not_recorded(
    body: Body, folder: Path, listener_token: Path, tmp_path: Path
) -> None:
    scene = Scene()
    (tmp_path / "operator.token").write_text(token("operator"))
    async with (
        body.application("visitor") as sender,
        sender.send(microphone=scene.microphone, consent=[LIVE, Purpose.AGENT]) as sent,
    ):
        (visitor,) = await sender.visitors("robot", purposes=[RECORDING])
        ref = visitor.visitor_ref
        options = ("--gateway", body.url, "--token-file", listener_token)

        async def refused(file: str, named: str, *given: str | Path) -> str:
            status, said = await finish(await begin("record", folder / file, "--visitor", named, *options, *given))
            assert status == 1
            assert names(folder) == []
            return said.splitlines()[-1]

        assert f"{ref} does not consent to recording" in await refused("a.wav", ref)
        assert f"there is no visitor 'urn:ann'; there are: {ref} (microphone)" in await refused("a.wav", "urn:ann")
        assert "of other; there are: none" in await refused("a.wav", ref, "--body", "other")
        await sent.consent(RECORDING)
        assert "only the role listener" in await refused("a.wav", ref, "--token-file", tmp_path / "operator.token")
        # A file for pictures has the sound alone, where that is all that is sent.
        async with recording(body, folder / "b.webm", ref, listener_token, "--seconds", "0.5") as process:
            status, said = await finish(process)
        assert status == 0, said
        assert read_back(folder / "b.webm").codecs == {"audio": "opus"}


async def test_what_a_visitor_does_not_send_is_said(body: Body, folder: Path, listener_token: Path) -> None:
    async with (
        body.application("visitor") as sender,
        sender.send(camera=Scene().camera, consent=[RECORDING]),
    ):
        (visitor,) = await sender.visitors("robot", purposes=[RECORDING])
        ref = visitor.visitor_ref
        options = ("--gateway", body.url, "--token-file", listener_token, "--visitor", ref)
        status, said = await finish(await begin("record", folder / "a.wav", *options))
        assert (status, said) == (1, f"openrois record: {ref} sends no sound\n")


def test_a_visitor_is_no_component(capsys: pytest.CaptureFixture[str], folder: Path) -> None:
    with pytest.raises(SystemExit, match="2"):
        record_command.main([str(folder / "a.wav"), "--visitor", "urn:ann", "--component", "robot/ears"])
    assert "leave out --component" in capsys.readouterr().err
