"""A speech that is pushed as sound: when it is heard, dry, finished and cut off, on a clock turned by hand."""

import asyncio

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.engines.animation.animator import MAX_TRACKS
from openrois_body.messages import Silence
from openrois_body.sound.mixer import MAX_QUEUED
from openrois_body.sound.playback import SoundOverrun
from openrois_body.speech.contract import NamedMark, Word
from openrois_body.speech.playout_delay import PLAYOUT
from openrois_body.speech.progress import MarkReached, SpeechBegan, SpeechEnded, SpeechStarved, WordSpoken
from openrois_body.speech.utterance import DRY_LIMIT, MOMENTS_LIMIT, Utterance
from openrois_streaming.source.source import RawAudio

from openrois.errors import Aborted, OutOfResources
from openrois.types.codes import CompletedStatus
from tests.body.speech.test_voice import Speaker
from tests.support.hearing import stereo_48k, voice
from tests.support.streaming import settle


def sound(seconds: float, value: int = 8000) -> NDArray[np.int16]:
    return np.full(round(seconds * 48_000), value, np.int16)


class Stage(Speaker):
    def __init__(self) -> None:
        super().__init__()
        self.played: list[int] = []

    def stream(self, text: str = "") -> tuple[Utterance, "asyncio.Future[None]"]:
        utterance = self.voice.make_utterance(text, on_played=self.played.append)
        return utterance, asyncio.ensure_future(self.voice.utter(utterance))

    def ends(self) -> list[SpeechEnded]:
        return [each for each in self.progress if isinstance(each, SpeechEnded)]

    def kinds(self) -> list[str]:
        return [type(each).__name__ for each in self.progress]


@pytest.fixture
async def stage() -> Stage:
    return Stage()


async def test_it_begins_with_its_first_sound_and_ends_when_the_last_was_heard(stage: Stage) -> None:
    utterance, playing = stage.stream("Hello")
    await settle()
    utterance.push(sound(0.3))
    begin = stage.speaks()[0].start_ns / 1e9
    assert 0.04 <= begin - stage.clock.now() <= 0.06
    await stage.clock.advance(0.2)
    utterance.push(sound(0.2))
    utterance.finish()
    await stage.clock.advance(begin + 0.5 + PLAYOUT - stage.clock.now() - 0.001)
    assert not playing.done()
    await stage.clock.advance(0.002)
    await playing
    began, ended = stage.progress
    assert isinstance(began, SpeechBegan)
    assert isinstance(ended, SpeechEnded)
    assert (began.text, stage.at[0]) == ("Hello", pytest.approx(begin + PLAYOUT))
    assert (ended.status, ended.reason, ended.heard_ms) == (CompletedStatus.OK, "", 500)
    assert stage.played[-1] == 24_000
    assert utterance.ahead == 0
    assert Silence() not in stage.told


async def test_the_mouth_moves_from_one_push_to_the_next(stage: Stage) -> None:
    utterance, playing = stage.stream()
    await settle()
    spoken = stereo_48k(voice(0.3))[:, 0]
    for number in range(3):
        utterance.push(spoken[number * 4_800 : (number + 1) * 4_800])
        await stage.clock.advance(0.1)
    utterance.finish()
    await stage.clock.advance(1)
    await playing
    moves = stage.speaks()
    begin = moves[0].start_ns / 1e6
    assert [(round(each.start_ns / 1e6 - begin), each.duration_ms) for each in moves] == [
        (0, 70),
        (70, 100),
        (170, 100),
        (270, 30),
    ]
    assert {"sil"} < {viseme.shape for each in moves for viseme in each.visemes}
    assert moves[-1].visemes[-1].shape == "sil"


@pytest.mark.parametrize("piece", [480, 960, 144_000])
async def test_lips_of_sound_far_ahead_are_told_in_time_and_an_engine_keeps_all(stage: Stage, piece: int) -> None:
    utterance, playing = stage.stream()
    spoken = stereo_48k(voice(3.0))[:, 0]
    for first in range(0, len(spoken), piece):
        utterance.push(spoken[first : first + piece])
    utterance.finish()
    told_at: list[float] = []
    for _ in range(320):
        told_at += [stage.clock.now()] * (len(stage.speaks()) - len(told_at))
        await stage.clock.advance(0.01)
    await stage.clock.advance(1)
    await playing
    moves = stage.speaks()
    begins = [each.start_ns / 1e9 for each in moves]
    ends = [begin + each.duration_ms / 1000 for begin, each in zip(begins, moves, strict=True)]
    assert ends[-1] - begins[0] == pytest.approx(3.0)
    assert begins[1:] == pytest.approx(ends[:-1], abs=0.002)
    assert all(begin >= at + 0.04 for begin, at in zip(begins, told_at, strict=True))
    # What ended half a second ago is forgotten by an engine.
    kept = [sum(at >= other and end > at - 0.55 for other, end in zip(told_at, ends, strict=True)) for at in told_at]
    assert max(kept) <= MAX_TRACKS


async def test_lips_go_on_with_the_sound_after_a_pause(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(stereo_48k(voice(1.0))[:, 0])
    utterance.finish()
    await stage.clock.advance(0.5)
    stage.voice.pause()
    await stage.clock.advance(1)
    rest, before = 1 - utterance.played / 48_000, len(stage.speaks())
    stage.voice.go_on()
    await stage.clock.advance(0.001)
    begin = stage.speaks()[before].start_ns / 1e9
    assert 0.03 < begin - stage.clock.now() <= 0.06
    await stage.clock.advance(3)
    await playing
    last = stage.speaks()[-1]
    assert last.start_ns / 1e9 + last.duration_ms / 1000 - begin == pytest.approx(rest, abs=0.002)


async def test_running_dry_is_told_once_each_time_and_what_comes_then_goes_on(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(0.2))
    await stage.clock.advance(2)
    utterance.push(sound(0.1))
    await stage.clock.advance(2)
    utterance.push(sound(0.1))
    utterance.finish()
    await stage.clock.advance(2)
    await playing
    assert stage.kinds() == ["SpeechBegan", "SpeechStarved", "SpeechStarved", "SpeechEnded"]
    told = [each.heard_ms for each in stage.progress if isinstance(each, SpeechStarved | SpeechEnded)]
    assert told == [200, 300, 400]
    first = stage.speaks()[0].start_ns / 1e9
    starved = stage.progress[1]
    wall = stage.clock.wall() - stage.clock.now()
    assert starved.at - wall == pytest.approx(first + 0.2 + PLAYOUT)


async def test_words_and_marks_are_told_when_they_are_heard_in_order_of_time(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.add_moments([Word(300, "you", 6), Word(0, "Hello", 0)])
    utterance.push(sound(0.25))
    await stage.clock.advance(0.1)
    utterance.add_moments([NamedMark(200, "here")])
    await stage.clock.advance(1.0)
    told = [each for each in stage.progress if isinstance(each, WordSpoken | MarkReached)]
    assert [getattr(each, "word", "<mark>") for each in told] == ["Hello", "<mark>"]
    utterance.push(sound(0.25))
    utterance.add_moments([Word(600, "never", 10)])
    utterance.finish()
    await stage.clock.advance(1.0)
    await playing
    assert stage.words() == [("Hello", 0), ("you", 6)]
    last = stage.ends()[0].last
    assert last is not None
    assert last.text == "you"


async def test_it_is_cut_off_within_a_block_and_says_how_much_was_heard(stage: Stage) -> None:
    blocks: list[RawAudio] = []
    listening = asyncio.create_task(stage.listen(blocks))
    utterance, playing = stage.stream()
    utterance.push(sound(1.0))
    await stage.clock.advance(0.55)
    now = stage.clock.now()
    utterance.cut("the stream was cleared")
    await settle()
    with pytest.raises(Aborted, match=r"^the stream was cleared 0\.5 s after its first sound$"):
        await playing
    await stage.clock.advance(1.0)
    listening.cancel()
    await asyncio.wait({listening})
    loud = [block.captured_at + index / 48_000 for block in blocks for index in np.flatnonzero(block.samples)]
    assert max(loud) < now + 0.025
    ended = stage.ends()[0]
    assert (ended.status, ended.heard_ms) == (
        CompletedStatus.ABORT,
        pytest.approx((max(loud) - min(loud)) * 1000, abs=10),
    )
    assert stage.told[-1] == Silence()
    utterance.push(sound(1.0))
    assert utterance.is_ended


async def test_before_it_has_a_turn_it_can_be_cut_off(stage: Stage) -> None:
    first, playing = stage.stream()
    first.push(sound(0.1))
    second, waiting = stage.stream()
    second.push(sound(0.1))
    await settle()
    second.cut("enough")
    with pytest.raises(Aborted, match=r"^enough before its first sound$"):
        await waiting
    first.finish()
    await stage.clock.advance(1)
    await playing
    assert stage.ends()[0].heard_ms == 0


async def test_texts_and_streams_wait_for_each_other_without_a_pause_between_them(stage: Stage) -> None:
    before = stage.say("one")
    await settle()
    utterance, playing = stage.stream()
    utterance.push(sound(0.5))
    await settle()
    after = stage.say("two")
    await stage.clock.advance(1.2)
    assert before.done() is False
    assert len(stage.speaks()) == 2
    utterance.finish()
    await stage.clock.advance(0.2)
    text, *stream, last = stage.speaks()
    assert [(each.start_ns - text.start_ns) // 1_000_000 for each in (*stream, last)] == [1_000, 1_470, 1_500]
    await stage.clock.advance(3)
    await asyncio.gather(before, playing, after)


async def test_what_waits_is_heard_at_once_when_what_is_spoken_is_cut_off(stage: Stage) -> None:
    first, playing = stage.stream()
    first.push(sound(10))
    first.finish()
    second, waiting = stage.stream()
    second.push(sound(0.5))
    second.finish()
    await stage.clock.advance(1)
    cut_at = stage.clock.now()
    first.cut("enough")
    await settle()
    begins = next(each for each in stage.speaks() if each.id == second.speech_id).start_ns / 1e9
    assert begins - cut_at <= 0.06
    with pytest.raises(Aborted):
        await playing
    await stage.clock.advance(1)
    await waiting


async def test_a_pause_is_silence_and_it_goes_on_where_it_was(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(1.0))
    utterance.add_moments([Word(800, "late", 0)])
    await stage.clock.advance(0.5)
    stage.voice.pause()
    await stage.clock.advance(5)
    heard = utterance.played
    assert heard == pytest.approx(0.44 * 48_000, abs=1_000)
    utterance.push(sound(0.5))
    utterance.finish()
    stage.voice.go_on()
    await stage.clock.advance(1.5 - heard / 48_000 + 0.07 + PLAYOUT)
    await playing
    assert stage.words() == [("late", 0)]
    assert stage.ends()[0].heard_ms == 1500


async def test_pause_and_resume_in_one_turn_lose_nothing(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(0.5))
    await stage.clock.advance(0.2)
    stage.voice.pause()
    stage.voice.go_on()
    utterance.push(sound(0.5))
    utterance.finish()
    await stage.clock.advance(3)
    await playing
    assert stage.ends()[0].heard_ms == 1000


async def test_room_comes_as_it_is_played(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(2.0))
    waiting = asyncio.ensure_future(utterance.room(1.0))
    await stage.clock.advance(0.9)
    assert not waiting.done()
    await stage.clock.advance(0.4)
    await waiting
    waiting = asyncio.ensure_future(utterance.room(0.1))
    await settle()
    utterance.cut("enough")
    await waiting
    with pytest.raises(Aborted):
        await playing


async def test_what_waits_is_bounded(stage: Stage) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(60))
    with pytest.raises(SoundOverrun, match="60 seconds"):
        utterance.push(sound(0.1))
    utterance.add_moments([Word(number, "a", number) for number in range(MOMENTS_LIMIT)])
    with pytest.raises(SoundOverrun, match="words and marks"):
        utterance.add_moments([Word(1, "a", 1)])
    await settle()
    playing.cancel()
    await asyncio.wait({playing})
    assert stage.ends()[0].status is CompletedStatus.ABORT
    many = [stage.stream() for _ in range(MAX_QUEUED + 1)]
    await settle()
    with pytest.raises(OutOfResources, match="speeches wait already"):
        await many[-1][1]
    stage.voice.interrupt("enough")
    ends = await asyncio.gather(*(task for _, task in many), return_exceptions=True)
    assert [type(each) for each in ends] == [Aborted] * MAX_QUEUED + [OutOfResources]


@pytest.mark.parametrize("seconds", [0.0, 0.5])
async def test_one_whose_sound_stays_away_lets_the_next_one_speak(stage: Stage, seconds: float) -> None:
    utterance, playing = stage.stream()
    utterance.push(sound(seconds))
    following = stage.say("two")
    await stage.clock.advance(DRY_LIMIT + seconds - 0.1)
    assert not playing.done()
    await stage.clock.advance(0.2)
    with pytest.raises(Aborted, match=r"^no sound came for 30 s, and the speech ended"):
        await playing
    await stage.clock.advance(2)
    await following


async def test_without_any_sound_it_ends_at_once(stage: Stage) -> None:
    utterance, playing = stage.stream()
    await settle()
    utterance.finish()
    await playing
    assert stage.kinds() == ["SpeechEnded"]
