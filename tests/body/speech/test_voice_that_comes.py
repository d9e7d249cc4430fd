"""Texts that are heard while their sound is still coming, on a clock turned by hand and from a real server."""

import asyncio
import re
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from contextlib import aclosing, asynccontextmanager

import numpy as np
import pytest
from openrois_body.body import Body
from openrois_body.messages import Command, Silence, Speak, Viseme
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.contract import (
    NamedMark,
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    VoiceSettings,
    Word,
)
from openrois_body.speech.playout_delay import PLAYOUT
from openrois_body.speech.progress import (
    MarkReached,
    Progress,
    SpeechBegan,
    SpeechEnded,
    SpeechStarved,
    WordSpoken,
)
from openrois_body.speech.server_voice import ServerVoice
from openrois_body.speech.voice import AHEAD, Voice
from openrois_streaming.clock import SystemClock

from openrois.errors import Aborted, BadParameter, ComponentFailed
from openrois.types.codes import CompletedStatus
from tests.support.http_answers import silent
from tests.support.speech_server import Behaviour, SpeechServer, early_end, first_half, says, speech_server
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer


def piece(seconds: float, *words: Word, visemes: Sequence[Viseme] = (), mark: NamedMark | None = None) -> SpeechChunk:
    samples = np.full(round(seconds * 48_000), 8000, np.int16)
    return SpeechChunk(samples, words, tuple(visemes), () if mark is None else (mark,))


class Arriving(ScriptedSynthesizer):
    """Yields the pieces that the test puts, ends with None, and raises what is put as an error."""

    tells_visemes = False

    def __init__(self) -> None:
        super().__init__()
        self.pieces: asyncio.Queue[SpeechChunk | Exception | None] = asyncio.Queue()
        self.opened = self.closed = 0

    @asynccontextmanager
    async def speak(self, request: SpeechRequest) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        self.opened += 1
        try:
            async with aclosing(self._arriving()) as chunks:
                yield chunks
        finally:
            self.closed += 1

    async def _arriving(self) -> AsyncGenerator[SpeechChunk, None]:
        while (chunk := await self.pieces.get()) is not None:
            if isinstance(chunk, Exception):
                raise chunk
            yield chunk

    def put(self, *pieces: SpeechChunk | Exception | None) -> None:
        for each in pieces:
            self.pieces.put_nowait(each)


class Stage:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.synthesizer = Arriving()
        self.told: list[Command] = []
        self.sound = BodySound(self.clock)
        self.voice = Voice(self.synthesizer, self.sound, Body(self.told.append))
        self.progress: list[Progress] = []
        self.voice.progress.add(self.progress.append)

    def say(self, text: str = "one two") -> "asyncio.Future[None]":
        return asyncio.ensure_future(self.voice.say(text, ssml=False, language="en", character="default", volume=50))

    def kinds(self) -> Sequence[type[Progress]]:
        return [type(each) for each in self.progress]

    def end(self) -> SpeechEnded:
        (end,) = (each for each in self.progress if isinstance(each, SpeechEnded))
        return end

    def shapes(self, since: float) -> list[tuple[float, str]]:
        """Each shape of the mouth with the seconds from `since` to it, and the end of each movement."""
        found: list[tuple[float, str]] = []
        for each in self.told:
            if isinstance(each, Speak):
                begin = each.start_ns / 1e9 - since
                found += [(begin + viseme.offset_ms / 1000, viseme.shape) for viseme in each.visemes]
                found.append((begin + each.duration_ms / 1000, "end"))
        return [(round(moment, 3), shape) for moment, shape in found]


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    yield stage
    await settle()
    assert stage.synthesizer.opened == stage.synthesizer.closed


async def test_what_has_come_is_heard_and_running_dry_is_silence_and_no_end(stage: Stage) -> None:
    saying = stage.say()
    stage.synthesizer.put(piece(0.5, Word(0.0, "one", 0)))
    await stage.clock.advance(0.06 + 0.5 + PLAYOUT)
    assert stage.kinds() == [SpeechBegan, WordSpoken, SpeechStarved]
    assert any(isinstance(each, Speak) for each in stage.told)
    await stage.clock.advance(3.0)
    assert not saying.done()
    stage.synthesizer.put(piece(0.5, Word(500.0, "two", 4)), None)
    await stage.clock.advance(0.06 + 0.5 + PLAYOUT + 0.1)
    await saying
    assert stage.kinds() == [SpeechBegan, WordSpoken, SpeechStarved, WordSpoken, SpeechEnded]
    assert (stage.end().status, stage.end().heard_ms) == (CompletedStatus.OK, 1000)


@pytest.mark.parametrize(
    ("error", "raised"), [(SpeechUnavailable("it is away"), ComponentFailed), (SpeechRefused("no"), BadParameter)]
)
async def test_a_failure_before_the_first_sound_is_the_failure_of_the_text(
    stage: Stage, error: Exception, raised: type[Exception]
) -> None:
    stage.synthesizer.put(error)
    with pytest.raises(raised, match=f"^{error}$"):
        await stage.say()
    assert stage.end().reason == f"{error}; the speech ended before its first sound"


async def test_a_failure_in_the_middle_lets_the_rest_fall_silent(stage: Stage) -> None:
    saying = stage.say()
    stage.synthesizer.put(piece(2.0))
    await stage.clock.advance(1.0)
    stage.synthesizer.put(SpeechUnavailable("it is away"))
    await stage.clock.advance(0.1)
    with pytest.raises(ComponentFailed, match=r"^it is away$"):
        await saying
    assert stage.told[-1] == Silence()
    assert stage.end().status is CompletedStatus.ABORT
    assert re.fullmatch(r"it is away; the speech ended (0\.9|1\.0) s after its first sound", stage.end().reason)


async def test_interrupting_and_cancelling_end_what_comes(stage: Stage) -> None:
    saying, waiting = stage.say(), stage.say()
    stage.synthesizer.put(piece(2.0))
    await stage.clock.advance(1.0)
    stage.voice.interrupt("a person spoke")
    await stage.voice.silent()
    with pytest.raises(Aborted, match=r"^a person spoke \d\.\d s after its first sound$"):
        await saying
    with pytest.raises(Aborted, match=r"^a person spoke before its first sound$"):
        await waiting
    cancelled = stage.say()
    stage.synthesizer.put(piece(2.0))
    await stage.clock.advance(1.0)
    cancelled.cancel()
    with pytest.raises(asyncio.CancelledError):
        await cancelled


async def test_a_pause_keeps_what_comes_meanwhile(stage: Stage) -> None:
    saying = stage.say()
    stage.synthesizer.put(piece(1.0))
    await stage.clock.advance(0.5)
    stage.voice.pause()
    stage.synthesizer.put(piece(1.0), None)
    await stage.clock.advance(5.0)
    assert not saying.done()
    stage.voice.go_on()
    await stage.clock.advance(3.0)
    await saying
    assert stage.end().heard_ms == pytest.approx(2000, abs=1)


async def test_a_text_whose_mouth_shapes_are_told_is_heard_before_it_is_made(stage: Stage) -> None:
    stage.synthesizer.tells_visemes = True
    saying = stage.say()
    stage.synthesizer.put(piece(0.2, Word(0.0, "one", 0), visemes=[Viseme(0.0, "PP", 1.0), Viseme(150.0, "aa", 0.9)]))
    await settle()
    begin = next(each for each in stage.told if isinstance(each, Speak)).start_ns / 1e9
    assert stage.shapes(begin) == [(0.0, "PP"), (0.15, "aa"), (0.2, "end")]
    await stage.clock.advance(0.1)
    stage.synthesizer.put(piece(0.5, Word(300.0, "two", 4), visemes=[Viseme(300.0, "SS", 1.0)]))
    await settle()
    assert stage.shapes(begin)[3:] == [(0.2, "aa"), (0.3, "SS"), (0.7, "end")]
    stage.synthesizer.put(piece(0.3, visemes=[Viseme(1000.0, "sil", 1.0)], mark=NamedMark(1000.0, "here")), None)
    await stage.clock.advance(begin + 1.0 + PLAYOUT - stage.clock.now() - 0.001)
    assert not saying.done()
    await stage.clock.advance(0.002)
    await saying
    assert stage.shapes(begin)[6:] == [(0.7, "SS"), (1.0, "end")]
    assert stage.kinds() == [SpeechBegan, WordSpoken, WordSpoken, MarkReached, SpeechEnded]
    wall = stage.clock.wall() - stage.clock.now() + begin + PLAYOUT
    assert [each.at - wall for each in stage.progress] == pytest.approx([0.0, 0.0, 0.3, 1.0, 1.0], abs=0.002)
    assert stage.end().heard_ms == 1000


async def test_after_a_pause_the_mouth_goes_on_with_the_shape_that_it_had(stage: Stage) -> None:
    stage.synthesizer.tells_visemes = True
    saying = stage.say()
    stage.synthesizer.put(piece(1.0, visemes=[Viseme(0.0, "aa", 1.0), Viseme(800.0, "SS", 1.0)]))
    await stage.clock.advance(0.5)
    stage.voice.pause()
    stage.synthesizer.put(piece(1.0, visemes=[Viseme(1200.0, "PP", 1.0), Viseme(2000.0, "sil", 1.0)]), None)
    await stage.clock.advance(3.0)
    assert stage.told[-1] == Silence()
    before = len(stage.told)
    stage.voice.go_on()
    await settle()
    begin = stage.told[before].start_ns / 1e9  # type: ignore[union-attr]
    assert 0.03 < begin - stage.clock.now() <= 0.061
    del stage.told[:before]
    await stage.clock.advance(3.0)
    await saying
    left = stage.shapes(begin)[-1][0]
    assert 1.5 < left < 1.6
    heard = 2.0 - left
    # What is told again is the shape that is shown; all others are told once.
    told = [(moment, shape) for moment, shape in stage.shapes(begin) if shape != "end"]
    assert told[0] == (0.0, "aa")
    assert (pytest.approx(0.8 - heard, abs=0.002), "SS") in told
    assert (pytest.approx(1.2 - heard, abs=0.002), "PP") in told


async def test_of_a_long_text_few_movements_are_told(stage: Stage) -> None:
    stage.synthesizer.tells_visemes = True
    saying = stage.say()
    shapes = [Viseme(100.0 * number, ("aa", "PP")[number % 2], 1.0) for number in range(600)]
    for number in range(120):
        stage.synthesizer.put(piece(0.5, visemes=shapes[5 * number : 5 * number + 5]))
    stage.synthesizer.put(None)
    await stage.clock.advance(62.0)
    await saying
    movements = [each for each in stage.told if isinstance(each, Speak)]
    assert len(movements) < 12
    begin = movements[0].start_ns / 1e9
    moments = [moment for moment, shape in stage.shapes(begin) if shape != "end"]
    assert moments == sorted(moments)
    assert {round(0.1 * number, 3) for number in range(600)} <= set(moments)
    # Each begins where the one before it ends.
    ends = [each.start_ns / 1e9 + each.duration_ms / 1000 for each in movements]
    assert [each.start_ns / 1e9 for each in movements[1:]] == pytest.approx(ends[:-1], abs=0.002)


async def test_no_more_is_taken_than_may_wait(stage: Stage) -> None:
    saying = stage.say()
    # A piece may be longer than what may wait.
    stage.synthesizer.put(piece(100.0), *[piece(1.0) for _ in range(50)], None)
    await stage.clock.advance(60.0)
    assert stage.synthesizer.pieces.qsize() == 51
    await stage.clock.advance(30.0)
    assert 50 - AHEAD < stage.synthesizer.pieces.qsize() < 50
    await stage.clock.advance(65.0)
    await saying
    assert stage.end().heard_ms == 150_000


class TestServer:
    """The sound of a real server, heard at the body's sound by the real clock."""

    behaviour: Behaviour
    server: SpeechServer

    @asynccontextmanager
    async def spoken(self) -> AsyncIterator[tuple[Voice, asyncio.Event, list[Progress], ServerVoice]]:
        """Run a voice; the event is set when something loud leaves the body."""
        async with asyncio.timeout(60), speech_server() as server:
            server.behaviour = self.behaviour
            self.server = server
            async with ServerVoice(VoiceSettings(server.address)) as synthesizer:
                sound = BodySound(SystemClock())
                voice = Voice(synthesizer, sound, Body(lambda _command: None))
                progress: list[Progress] = []
                voice.progress.add(progress.append)
                loud = asyncio.Event()

                async def listen() -> None:
                    async with sound.open() as blocks:
                        async for block in blocks:
                            if np.abs(block.samples).max() > 1000:
                                loud.set()

                listening = asyncio.create_task(listen())
                try:
                    yield voice, loud, progress, synthesizer
                finally:
                    listening.cancel()
                    await asyncio.wait({listening})

    @pytest.mark.engine
    async def test_the_first_half_of_a_sentence_is_heard_before_the_server_has_made_the_second(self) -> None:
        self.behaviour = first_half
        async with self.spoken() as (voice, loud, progress, _):
            saying = asyncio.ensure_future(
                voice.say("Good morning, and welcome.", ssml=False, language="en", character="default", volume=100)
            )
            await loud.wait()
            assert not self.server.go_on.is_set()
            self.server.go_on.set()
            await saying
        assert isinstance(progress[0], SpeechBegan)
        assert progress[0].text == "Good morning, and welcome."
        assert isinstance(progress[-1], SpeechEnded)
        assert progress[-1].status is CompletedStatus.OK

    @pytest.mark.engine
    @pytest.mark.parametrize(
        ("behaviour", "said"), [(early_end, "closed the connection"), (says(429, ""), "takes no more now")]
    )
    async def test_what_the_server_does_wrong_is_the_reason_of_the_end(self, behaviour: Behaviour, said: str) -> None:
        self.behaviour = behaviour
        async with self.spoken() as (voice, _, progress, _):
            with pytest.raises(ComponentFailed, match=said):
                await voice.say("Good morning.", ssml=False, language="en", character="default", volume=100)
        (ended,) = (each for each in progress if isinstance(each, SpeechEnded))
        assert said in ended.reason

    @pytest.mark.engine
    async def test_a_speech_that_waits_for_its_server_is_cut_off_at_once(self) -> None:
        self.behaviour = silent
        async with self.spoken() as (voice, _, _, _):
            saying = asyncio.ensure_future(
                voice.say("Good morning.", ssml=False, language="en", character="default", volume=100)
            )
            await self.server.arrived.acquire()
            voice.interrupt("the speech was stopped")
            with pytest.raises(Aborted, match="the speech was stopped before its first sound"):
                await saying
