"""Speech over real WebRTC: what a viewer hears of it, and what is reported of that."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from itertools import chain, repeat

import numpy as np
import pytest
from openrois_body.body import Body
from openrois_body.messages import Silence, Viseme
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.contract import Speech, Word
from openrois_body.speech.lips import ToldLips
from openrois_body.speech.playout_delay import PLAYOUT, PlayoutDelay
from openrois_body.speech.progress import Progress, WordSpoken
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech.turns import Line
from openrois_body.speech.utterance import Utterance
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.publisher import AudioPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink
from openrois_streaming.testing.stage import AUDIO, playing

from openrois.errors import Aborted

pytestmark = pytest.mark.media

LOUD = 300
"""Of 32,767; what Opus makes of silence is below."""


class Noted(PlayoutDelay):
    """Keeps what it has said of its lateness last."""

    said = 0.0

    async def lateness(self) -> float:
        self.said = await super().lateness()
        return self.said


@dataclass
class Hearing:
    """An avatar's voice, and a viewer on this machine that hears it."""

    clock: SystemClock
    sound: BodySound
    sink: MeasuringSink
    session: StreamSession
    playout_delay: Noted
    heard: list[tuple[float, RawAudio]]
    """Blocks with the moments at which they were played."""
    progress: list[Progress] = field(default_factory=list)
    silences: list[float] = field(default_factory=list)

    def utterance(self, speech: Speech) -> Utterance:
        body = Body(lambda command: self.silences.append(self.clock.now()) if command == Silence() else None)
        return whole(speech, self.sound, body, self.playout_delay, self.progress.append)

    def loud(self) -> list[tuple[float, float]]:
        """The moments of samples that are heard, by the media clock, and when the last of its block was played."""
        found: list[tuple[float, float]] = []
        for played, block in self.heard:
            for index in np.flatnonzero(np.abs(block.samples[:, 0]) > LOUD):
                found.append((block.captured_at + float(index) / 48_000, played + len(block.samples) / 48_000))
        return found

    @property
    def made_up(self) -> float:
        """Seconds of sound that had not come in time: a viewer on a busy machine goes on with what it heard last."""
        return self.sink.received("0").concealed

    def has_heard(self, last: tuple[float, float], ended: float, made_up: float) -> bool:
        """Whether it ended when the last sample had been heard, as far as the avatar knows the delay to there.

        A viewer on a busy machine hears it later than it said, and more than there was.
        """
        captured, played = last
        return captured + min(played - captured, self.playout_delay.said) < ended + made_up

    def onsets(self) -> list[float]:
        """The media times at which sound begins after 50 ms of silence or more."""
        moments = np.array([moment for moment, _ in self.loud()])
        return [float(moments[0]), *(float(moments[index + 1]) for index in np.flatnonzero(np.diff(moments) > 0.05))]

    async def until(self, so: Callable[[], object]) -> None:
        await self.sink.until(so)

    async def heard_until(self, moment: float) -> None:
        """Wait until the viewer has heard what was captured at a moment of the media clock."""
        await self.until(lambda: self.heard and self.heard[-1][1].captured_at >= moment)


def whole(
    speech: Speech, sound: BodySound, body: Body, delay: PlayoutDelay, on_progress: Callable[[Progress], None]
) -> Utterance:
    """A speech that has come as a whole before it is played."""
    lips = ToldLips()
    lips.add(speech.visemes)
    utterance = Utterance(sound, body, delay, on_progress, Line(sound.clock), lips=lips)
    utterance.add_moments(speech.words)
    utterance.push(speech.samples)
    utterance.finish()
    return utterance


@asynccontextmanager
async def hearing(path: ImpairedPath | None = None) -> AsyncIterator[Hearing]:
    clock, blocks = SystemClock(), list[tuple[float, RawAudio]]()

    def take(media: RawVideo | RawAudio) -> None:
        assert isinstance(media, RawAudio)
        blocks.append((clock.now(), media))

    sound, playout_delay = BodySound(clock), Noted()
    async with (
        asyncio.timeout(60),
        MeasuringSink(path=path, on_media=take) as sink,
        playing(sink, audio=AudioPublisher(sound, clock=clock)) as session,
    ):
        playout_delay.observe_sessions((session,), "stage/Audio")
        await sink.hears(20)
        yield Hearing(clock, sound, sink, session, playout_delay, blocks)


def bursts(count: int) -> Speech:
    """So many words, each a hum of 100 ms, with as much silence between them."""
    hum = np.sin(2 * np.pi * 300 * np.arange(4_800) / 48_000) * 12_000
    samples = np.tile(np.concatenate((hum, np.zeros(4_800))).astype(np.int16), count)[:-4_800]
    words = tuple(Word(200.0 * number, f"w{number}", 3 * number) for number in range(count))
    return Speech(samples, words, (Viseme(0.0, "aa", 1.0),))


async def test_the_end_of_a_speech_comes_when_its_last_sample_was_heard() -> None:
    async with hearing() as viewer, Synthesizer() as synthesizer:
        speech = await synthesizer.synthesize("Papa, the end comes now!", volume=100)
        before = viewer.made_up
        await viewer.utterance(speech).play()
        ended = viewer.clock.now()
        await viewer.heard_until(ended + 0.3)
        loud, made_up = viewer.loud(), viewer.made_up - before
        assert loud[-1][0] - loud[0][0] == pytest.approx(speech.duration, abs=0.6 + made_up)
        assert viewer.has_heard(loud[-1], ended, made_up)
        told = [each.word for each in viewer.progress if isinstance(each, WordSpoken)]
        assert told == ["Papa", "the", "end", "comes", "now"]


async def test_over_a_long_way_it_comes_so_much_later() -> None:
    far = Impairments(delay=0.15)
    async with ImpairedPath(far, far, seed=5) as path, hearing(path) as viewer:
        stats = await viewer.session.stats(AUDIO)
        while (stats.round_trip_time or 0) < 0.25:
            await viewer.sink.hears(20)
            stats = await viewer.session.stats(AUDIO)
        begun, before = viewer.clock.now(), viewer.made_up
        await viewer.utterance(bursts(3)).play()
        ended = viewer.clock.now()
        await viewer.heard_until(ended + 0.3)
        loud = [each for each in viewer.loud() if each[0] > begun]
        assert await viewer.playout_delay.lateness() > PLAYOUT + 0.12
        assert loud[0][1] > begun + far.delay
        assert viewer.has_heard(loud[-1], ended, viewer.made_up - before)


async def test_words_are_told_in_order_with_the_times_at_which_they_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    async with hearing() as viewer:
        late = 0.2

        async def lateness() -> float:
            return late

        # What the way adds is measured, and on a busy machine not the same a moment later.
        monkeypatch.setattr(viewer.playout_delay, "lateness", lateness)
        before = viewer.made_up
        await viewer.utterance(bursts(4)).play()
        told = [each for each in viewer.progress if isinstance(each, WordSpoken)]
        assert [each.word for each in told] == ["w0", "w1", "w2", "w3"]
        offset = viewer.clock.wall() - viewer.clock.now()
        moments = [each.at - offset - late for each in told]
        # Where a busy machine's viewer makes sound up, others begin as well, and some a little beside.
        onsets, made_up = viewer.onsets(), viewer.made_up - before
        assert len(onsets) == 4 or made_up
        assert max(min(abs(moment - onset) for onset in onsets) for moment in moments) < 0.02 + made_up


async def test_a_viewer_that_becomes_slower_meanwhile_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, playout_delay = SystemClock(), PlayoutDelay()
    sound, waits = BodySound(clock), chain((0.05,), repeat(0.3))

    async def lateness() -> float:
        return next(waits)

    monkeypatch.setattr(playout_delay, "lateness", lateness)
    hum = Speech(bursts(1).samples, (), ())
    begun = clock.now()
    await whole(hum, sound, Body(lambda _command: None), playout_delay, lambda _told: None).play()
    assert clock.now() >= begun + hum.duration + 0.3


async def test_cut_speech_is_silent_within_150_ms_and_so_is_the_mouth() -> None:
    async with hearing() as viewer, Synthesizer() as synthesizer:
        speech = await synthesizer.synthesize("a " + "very " * 30 + "long story", volume=100)
        utterance = viewer.utterance(speech)
        playing = asyncio.ensure_future(utterance.play())
        await viewer.until(lambda: len(viewer.loud()) > 24_000)
        stopped, before = viewer.clock.now(), viewer.made_up
        utterance.cut("it was stopped")
        with pytest.raises(Aborted, match="it was stopped at the word 'very'"):
            await playing
        gone = viewer.clock.now()
        # A busy machine may come to it late: the mouth was told to rest when the sound was cut, and before all ended.
        (silent,) = viewer.silences
        assert stopped <= silent <= gone
        await viewer.heard_until(silent + 0.4)
        # By media time: 20 ms of a block, 5 of the fading, and what the codec smears.
        assert max(moment for moment, _ in viewer.loud()) < silent + 0.05 + viewer.made_up - before
