"""An application that speaks by sound: real gateway, real adapter of an avatar, real WebRTC."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.body import Body as AvatarBody
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speech_control import SpeechControl
from openrois_body.speech.voice import Voice
from openrois_media import Media
from openrois_media.client.speaking import SpokenWord
from openrois_media.client.stream import News
from openrois_streaming.clock import SystemClock
from openrois_streaming.input.speech import Finished, Started, Starved

from openrois.aio.tasks import TaskScope
from openrois.client import Aborted, BadParameter, Client, ConnectionLost, OutOfResources, Unsupported
from tests.support.loopback import PATIENCE
from tests.support.media_body import application, body
from tests.support.operated import operated_avatar
from tests.support.voice import ScriptedSynthesizer

pytestmark = pytest.mark.media

SOUND = "avatar/audio_streaming"


@pytest.fixture
async def url(tmp_path: Path) -> AsyncIterator[str]:
    async with operated_avatar(tmp_path) as (running, _):
        yield running.url.replace("http", "ws")


@asynccontextmanager
async def program(url: str) -> AsyncIterator[tuple[Client, Media]]:
    async with asyncio.timeout(PATIENCE), Client(url) as client, Media(client) as media:
        yield client, media


def tone(seconds: float, rate: int = 48_000, pitch: float = 300) -> NDArray[np.float32]:
    return np.asarray(np.sin(2 * np.pi * pitch * np.arange(round(seconds * rate)) / rate) * 0.5, np.float32)


class Ear:
    """What is heard of the avatar."""

    def __init__(self) -> None:
        self.seconds = 0.0
        """Of loud sound."""
        self._pitches: list[float] = []
        """Of each block of loud sound."""
        self._news = News()
        self._hears = False

    async def listen(self, media: Media) -> None:
        async with media.blocks(SOUND) as blocks:
            async for block in blocks:
                self._hears = True
                sound = block.samples[:, 0].astype(float)
                if np.abs(sound).max() > 4_000:
                    self.seconds += len(sound) / 48_000
                    crossings = int(np.count_nonzero(np.diff(np.signbit(sound))))
                    self._pitches.append(crossings / 2 / len(sound) * 48_000)
                self._news.notify()

    async def hears(self) -> None:
        """Wait until the sound of the body comes, loud or not."""
        await self._news.until(lambda: self._hears)

    async def heard(self, pitch: float) -> None:
        """Wait until a pitch was heard: the way to a viewer is longer on a busy machine, and parts of it are lost."""
        await self._news.until(lambda: any(abs(each - pitch) < 60 for each in self._pitches))


@asynccontextmanager
async def hearing(media: Media) -> AsyncIterator[Ear]:
    """Hear the avatar; what it says before this begins would be missed."""
    ear = Ear()
    listening = asyncio.create_task(ear.listen(media))
    try:
        await ear.hears()
        yield ear
    finally:
        listening.cancel()
        await asyncio.wait({listening})


@pytest.mark.parametrize(("rate", "format"), [(16_000, "pcm16"), (24_000, "pcm16"), (48_000, "opus")])
async def test_more_than_the_credit_is_pushed_and_heard_to_its_end(url: str, rate: int, format: str) -> None:
    async with program(url) as (_, media), hearing(media) as ear:
        async with media.speech("avatar", rate=rate, format=format) as speech:  # type: ignore[arg-type]
            await speech.push(np.concatenate([tone(1.51, rate), tone(0.5, rate, 600)]), text="Beep")
            assert speech.played > 0.5
            spoken = await speech.finish()
            assert (spoken.reason, spoken.interrupted) == ("", False)
            assert spoken.seconds == pytest.approx(2.01, abs=0.02)
        await ear.heard(300)
        await ear.heard(600)
        # What a busy machine's viewer makes up, where sound comes late, is loud too.
        assert ear.seconds < 3.0


async def test_it_is_told_when_it_is_heard_runs_dry_and_ends(url: str) -> None:
    async with program(url) as (client, media):
        words = client.component("avatar/speech_progress").event("word_spoken")
        async with words, media.speech() as speech:
            events = speech.events()
            speech.add_words([SpokenWord("beep", 0.1)], text="beep")
            await speech.push((tone(0.3)[:, np.newaxis] * 30_000).astype(np.int16))
            started = await anext(events)
            assert isinstance(started, Started)
            number = started.utterance
            assert await anext(events) == Starved(number, 300)
            await speech.push(tone(0.2))
            assert (await speech.finish()).seconds == 0.5
            assert await anext(events) == Finished(number, 500)
            assert (await anext(words))["word"] == "beep"
            await speech.push(tone(0.1))
        assert [step async for step in events][-1] == Finished(number + 1, 100)


async def test_how_much_was_played_is_known_until_the_end_is_heard_and_afterwards(url: str) -> None:
    async with program(url) as (_, media), media.speech("avatar") as speech:
        await speech.until_played(1.0)
        assert (speech.utterance, speech.played) == (None, 0.0)
        await speech.push(tone(0.55))
        # The end of what was pushed is less than a step of credit behind what was told before it.
        await speech.until_played(0.55)
        first = speech.utterance
        assert first is not None
        assert speech.played == pytest.approx(0.55)
        await speech.push(tone(0.4))
        ended = asyncio.create_task(speech.finish())
        await speech.until_played(0.75)
        assert speech.utterance == first
        await ended
        assert speech.played == pytest.approx(0.95)
        await speech.until_played(2.0)
        await speech.push(tone(0.1))
        assert speech.utterance == first + 1


async def test_clear_silences_it_and_says_what_was_heard(url: str) -> None:
    async with program(url) as (_, media), media.speech("avatar") as speech:
        assert await speech.clear() == await speech.finish()
        await speech.push(tone(1.2))
        ended = asyncio.create_task(speech.finish())
        await anext(speech.events())
        spoken = await speech.clear()
        assert spoken.reason.startswith("the speech was cleared")
        assert 0.1 < spoken.seconds < 1.2
        assert await ended == spoken


async def test_a_push_that_waits_for_credit_fails_when_the_speech_is_interrupted(url: str) -> None:
    async with program(url) as (client, media), media.speech("avatar") as speech:
        pushing = asyncio.create_task(speech.push(tone(20)))
        await anext(speech.events())
        await client.component(speech.component_ref).command("stop")
        with pytest.raises(Aborted, match="the speech was stopped"):
            await pushing
        await speech.push(tone(0.1))
        assert (await speech.finish()).seconds == pytest.approx(0.1)


@pytest.mark.parametrize("how", ["clear", "stop"])
async def test_pushes_that_wait_behind_one_that_is_silenced_are_not_spoken(url: str, how: str) -> None:
    async with program(url) as (client, media), media.speech("avatar") as speech:
        pushing = [asyncio.create_task(speech.push(tone(20))) for _ in range(3)]
        await anext(speech.events())
        if how == "clear":
            await speech.clear()
        else:
            await client.component(speech.component_ref).command("stop")
        ends = await asyncio.gather(*pushing, return_exceptions=True)
        assert [type(end) for end in ends] == [Aborted] * 3
        assert await speech.finish() == await speech.clear()
        await speech.push(tone(0.1))
        assert (await speech.finish()).seconds == pytest.approx(0.1)


async def test_what_fails_inside_the_block_silences_the_body_and_gives_it_back(url: str) -> None:
    async with program(url) as (client, media):

        async def fail() -> None:
            async with media.speech("avatar") as speech:
                await speech.push(tone(1.0))
                raise ZeroDivisionError

        with pytest.raises(ZeroDivisionError):
            await fail()
        ended = client.component("avatar/speech_stream")
        async with asyncio.timeout(PATIENCE):
            while (await ended.query("streaming"))["speeches"]:
                pass
        async with Client(url) as other, Media(other) as others, others.speech("avatar") as speech:
            with pytest.raises(OutOfResources):
                async with media.speech("avatar"):
                    pass
            await speech.push(tone(0.1))


async def test_a_lost_adapter_ends_it_as_interrupted(tmp_path: Path) -> None:
    async with operated_avatar(tmp_path) as (running, _):
        url = running.url.replace("http", "ws")
        async with program(url) as (_, media), media.speech("avatar") as speech:
            pushing = asyncio.create_task(speech.push(tone(20)))
            await anext(speech.events())
            for peer in media._streams._peers.values():  # type: ignore[union-attr]
                await peer.connection.close()
            with pytest.raises(Aborted, match="the connection over which it was spoken was lost"):
                await pushing


async def test_a_replaced_connection_ends_it_as_interrupted_and_the_next_one_goes_over_the_new(url: str) -> None:
    async with program(url) as (client, media), media.speech("avatar") as speech:
        pushing = asyncio.create_task(speech.push(tone(20)))
        await anext(speech.events())
        (peer_id,) = media._streams._peers  # type: ignore[union-attr]
        await client.call("signaling.restart", peer_id=peer_id)
        with pytest.raises(Aborted, match="the connection over which it was spoken was lost"):
            await pushing
        while True:
            try:
                await speech.push(tone(0.1))
                break
            except ConnectionLost:
                await asyncio.sleep(0.05)
        assert (await speech.finish()).seconds == pytest.approx(0.1)
        assert (await client.component(speech.component_ref).query("streaming"))["speeches"] == 0


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        (np.zeros((10, 2), np.int16), "mix channels down"),
        (np.zeros(10, np.int32), "int16, or floats"),
    ],
)
async def test_other_arrays_are_refused(url: str, wrong: NDArray[np.int16], named: str) -> None:
    async with program(url) as (_, media), media.speech("avatar") as speech:
        with pytest.raises(ValueError, match=named):
            await speech.push(wrong)


async def test_a_body_that_speaks_no_sound_is_named() -> None:
    async with body() as robot, application(robot) as (_, media):
        with pytest.raises(Unsupported, match="no component of robot speaks by sound: there is no SpeechStream"):
            async with media.speech("robot"):
                pass
        for rate, format in ((44_100, "pcm16"), (16_000, "opus"), (48_000, "mp3")):
            with pytest.raises(ValueError, match="is not possible: use"):
                async with media.speech(rate=rate, format=format):  # type: ignore[arg-type]
                    pass


async def test_of_several_components_one_has_to_be_named() -> None:
    clock = SystemClock()
    voice = Voice(ScriptedSynthesizer(), BodySound(clock), AvatarBody(lambda _command: None))
    async with TaskScope() as tasks:
        both = [SpeechStream(SpeechControl(f"robot/{name}", voice, clock, tasks)) for name in ("one", "other")]
        for component, name in zip(both, ("one", "other"), strict=True):
            component.name = name
        async with body(others=both) as robot, application(robot) as (_, media):
            with pytest.raises(
                BadParameter, match="several components speak by sound, say which: robot/one, robot/other"
            ):
                async with media.speech():
                    pass


async def test_an_application_that_opens_its_media_anew_speaks_again(url: str) -> None:
    async with asyncio.timeout(PATIENCE), Client(url) as client:
        for _ in range(2):
            async with Media(client) as media, media.speech("avatar") as speech:
                await speech.push(tone(0.1))
                assert (await speech.finish()).seconds == pytest.approx(0.1)
