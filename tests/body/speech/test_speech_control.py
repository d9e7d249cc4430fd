"""Speech as a stream: who may speak, what is refused, and what is told, on a clock turned by hand."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.speech.playout_delay import PLAYOUT
from openrois_body.speech.progress import SpeechBegan, SpeechEnded, WordSpoken
from openrois_body.speech.speech_control import (
    FRAMES_AT_ONCE,
    STREAMS_AT_ONCE,
    WORDS_AT_ONCE,
    WORDS_PER_SECOND,
    SpeechControl,
    SpeechOutcomes,
)
from openrois_body.speech.utterance import DRY_LIMIT, MOMENTS_LIMIT
from openrois_streaming.input.messages import InputError
from openrois_streaming.input.reader import MALFORMED_LIMIT
from openrois_streaming.input.speech import (
    Begin,
    Clear,
    End,
    Finished,
    Frame,
    Granted,
    Refused,
    SpeechFormat,
    SpeechTold,
    Started,
    Starved,
    TimedWord,
    Words,
    pack_frame,
    read_speech,
    read_told,
)

from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.engine.registry import LocalRegistry
from openrois.types.streams import HolderNotification
from tests.body.speech.test_voice import Speaker
from tests.support.streaming import settle

REF = "avatar/speech_stream"


ANYTHING = st.tuples(st.sampled_from(["speech", "control"]), st.one_of(st.text(max_size=30), st.binary(max_size=30)))
FEW = st.integers(0, 3)
SPOKEN = st.one_of(
    st.builds(Begin, FEW, st.sampled_from(["pcm16", "opus"]), st.sampled_from([16_000, 48_000])),
    st.builds(Words, FEW, st.just((TimedWord("a", 0),))),
    st.builds(End, FEW),
    st.builds(Clear, FEW),
    st.builds(Frame, FEW, FEW, st.binary(min_size=1, max_size=20)),
).map(
    lambda each: (
        "control" if isinstance(each, Clear) else "speech",
        pack_frame(each) if isinstance(each, Frame) else json.dumps(each.to_json()),
    )
)


class Program:
    """An application with its end of the channels."""

    def __init__(self, control: SpeechControl, name: str) -> None:
        self.client = Client(name, lambda _method, _params: None)
        self.told: list[SpeechTold] = []
        self.sink = control.speech_sink(self.client, self._take)
        self.sequence = 0

    def _take(self, text: str) -> None:
        told = read_told(text)
        assert told is not None
        self.told.append(told)

    def say(self, message: Begin | Words | End | Clear) -> None:
        label = "control" if isinstance(message, Clear) else "speech"
        self.sink.input_came(label, json.dumps(message.to_json()))  # type: ignore[arg-type]

    def begin(self, number: int = 1, rate: int = 48_000, text: str = "") -> None:
        self.sequence = 0
        self.say(Begin(number, "pcm16", rate, text))

    def push(self, samples: int, number: int = 1) -> None:
        """Send sound in frames of 10 ms of 48 kHz."""
        while samples > 0:
            sound = np.full(min(samples, 480), 8000, "<i2").tobytes()
            self.sink.input_came("speech", pack_frame(Frame(number, self.sequence, sound)))
            self.sequence += 1
            samples -= 480

    def kinds(self) -> list[str]:
        return [type(each).__name__ for each in self.told if not isinstance(each, Granted)]


class Stage(Speaker):
    def __init__(self, tasks: TaskScope) -> None:
        super().__init__()
        self.control = SpeechControl(REF, self.voice, self.clock, tasks)
        self.ann, self.bob = Program(self.control, "ann"), Program(self.control, "bob")
        self.hold(self.ann)

    def hold(self, program: Program, epoch: int = 1, *, holds: bool = True, ref: str = REF) -> None:
        self.control.apply_holder(HolderNotification(component_ref=ref, holds=holds, epoch=epoch), program.client)


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    async with TaskScope() as tasks:
        yield Stage(tasks)


async def test_a_speech_is_started_played_and_finished(stage: Stage) -> None:
    stage.ann.begin(text="Hello there")
    stage.ann.push(24_000)
    stage.ann.say(Words(1, (TimedWord("there", 300),)))
    stage.ann.say(End(1))
    await stage.clock.advance(1.0)
    assert stage.ann.kinds() == ["Started", "Finished"]
    began, word, ended = stage.progress
    assert isinstance(began, SpeechBegan)
    assert isinstance(word, WordSpoken)
    assert isinstance(ended, SpeechEnded)
    assert (began.text, word.word, word.position) == ("Hello there", "there", 6)
    assert Started(1, began.speech_id) in stage.ann.told
    assert stage.ann.told[-1] == Finished(1, 500)
    assert (stage.control.streams, stage.control.figures.taken) == (0, 50)


@pytest.mark.parametrize("rate", [16_000, 24_000, 48_000])
async def test_credit_comes_as_it_is_played_and_more_than_that_ends_the_speech(stage: Stage, rate: int) -> None:
    stage.ann.begin(rate=rate)
    stage.ann.push(rate)
    await stage.clock.advance(0.5)
    credit = [each for each in stage.ann.told if isinstance(each, Granted)]
    assert [each.samples for each in credit] == [each.played + rate for each in credit]
    assert credit[-1].played == pytest.approx(0.44 * rate, abs=0.1 * rate)
    room = credit[-1].samples - rate
    stage.ann.push(room)
    await stage.clock.advance(0.01)
    stage.ann.push(480)
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert "were granted: wait for credit" in finished.reason
    assert 400 <= finished.position <= 500
    stage.ann.push(480)
    assert (stage.control.figures.dropped, stage.control.figures.malformed) == (1, 1)


async def test_only_the_application_that_holds_the_component_speaks(stage: Stage) -> None:
    stage.bob.begin()
    stage.bob.push(4_800)
    await settle()
    (refused,) = stage.bob.told
    assert isinstance(refused, Refused)
    assert refused.reason.startswith(f"{REF} has to be bound first; while it is lent")
    assert (stage.control.figures.dropped, stage.speaks()) == (10, [])
    stage.hold(stage.bob, ref="avatar/teleoperation")
    stage.bob.begin(2)
    assert stage.bob.kinds() == ["Refused", "Refused"]


@pytest.mark.parametrize(
    ("loses", "reason"),
    [
        (lambda stage: stage.hold(stage.ann, holds=False), "the component was released"),
        (lambda stage: stage.hold(stage.bob, 2), "another application has bound the component"),
        (lambda stage: stage.control.forget_client(stage.ann.client), "the application that spoke is gone"),
        (lambda stage: stage.ann.say(Clear(1)), "the speech was cleared"),
        (lambda stage: stage.voice.interrupt("a person spoke"), "a person spoke"),
    ],
)
async def test_a_speech_ends_as_interrupted_when(stage: Stage, loses: Any, reason: str) -> None:
    stage.ann.begin()
    stage.ann.push(48_000)
    await stage.clock.advance(0.56)
    loses(stage)
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert finished.reason == f"{reason} 0.5 s after its first sound"
    assert finished.position == pytest.approx(500, abs=25)
    assert stage.control.streams == 0


async def test_a_speech_ends_with_its_channels_and_nothing_is_told_of_it_over_others(stage: Stage) -> None:
    stage.ann.begin()
    stage.ann.push(48_000)
    await stage.clock.advance(0.56)
    told = len(stage.ann.told)
    stage.ann.sink.input_lost("the connection was lost")
    stage.ann.begin()
    stage.ann.push(480)
    stage.ann.say(End(1))
    await settle()
    former, *_ = (each for each in stage.progress if isinstance(each, SpeechEnded))
    assert former.reason == "the connection was lost 0.5 s after its first sound"
    await stage.clock.advance(1.0)
    assert [each for each in stage.ann.told[told:] if isinstance(each, Finished)] == [Finished(1, 10)]
    assert stage.control.streams == 0


async def test_what_an_old_epoch_says_of_the_holder_is_passed_over(stage: Stage) -> None:
    stage.hold(stage.bob, 5)
    stage.hold(stage.ann, 4)
    stage.hold(stage.ann, 3, holds=False)
    assert stage.control.holder is stage.bob.client
    stage.control.forget_client(stage.ann.client)
    assert stage.control.holder is stage.bob.client


async def test_clear_that_overtakes_begin_silences_the_speech_that_it_names(stage: Stage) -> None:
    stage.ann.say(Clear(1))
    stage.ann.begin()
    stage.ann.push(4_800)
    await settle()
    assert stage.ann.told == [Refused(1, "the speech was cleared")]
    stage.ann.say(Clear(1))
    stage.ann.begin(2)
    stage.ann.push(4_800, 2)
    await settle()
    assert len({each.id for each in stage.speaks()}) == 1


async def test_running_dry_is_told_to_the_application(stage: Stage) -> None:
    stage.ann.begin()
    stage.ann.push(9_600)
    await stage.clock.advance(0.5)
    assert stage.ann.told[-1] == Starved(1, 200)


async def test_speeches_are_counted_by_what_became_of_them(stage: Stage) -> None:
    stage.bob.begin()
    for number in (1, 2, 3):
        stage.ann.begin(number)
        stage.ann.push(4_800, number)
    stage.ann.say(End(1))
    stage.ann.say(Clear(3))
    await stage.clock.advance(1.0)
    assert stage.control.outcomes == SpeechOutcomes(begun=3, starved=1, finished=1, cut=1)


async def test_speeches_follow_each_other_and_their_number_is_bounded(stage: Stage) -> None:
    for number in range(1, STREAMS_AT_ONCE + 2):
        stage.ann.begin(number)
        stage.ann.push(480, number)
        stage.ann.say(End(number))
    await settle()
    (refused,) = stage.ann.told
    assert isinstance(refused, Refused)
    assert "8 speeches wait already" in refused.reason
    await stage.clock.advance(0.06 + 0.01 * STREAMS_AT_ONCE + PLAYOUT)
    finished = [each for each in stage.ann.told if isinstance(each, Finished)]
    assert finished == [Finished(number, 10) for number in range(1, STREAMS_AT_ONCE + 1)]
    starts = [each.start_ns for each in stage.speaks()]
    assert [later - earlier for earlier, later in pairwise(starts)] == [10_000_000] * 7


async def test_a_frame_before_its_speech_is_refused_once_a_second(stage: Stage) -> None:
    stage.ann.push(960, 3)
    assert stage.ann.told == [Refused(3, "a speech has to begin before its first frame")]
    await stage.clock.advance(1.0)
    stage.ann.push(480, 3)
    assert len(stage.ann.told) == 2


async def test_after_many_messages_that_cannot_be_read_nothing_more_is(stage: Stage) -> None:
    stage.ann.begin()
    stage.ann.push(4_800)
    await settle()
    for wrong in ("{}", b"", '{"event": "end", "utterance": 9}', '{"event": "begin", "utterance": 1}'):
        stage.ann.sink.input_came("speech", wrong)
    for _ in range(MALFORMED_LIMIT - 4):
        stage.ann.begin(1)
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert finished.reason.startswith("32 messages could not be read, the last one: utterance: must be greater than 1")
    stage.ann.begin(2)
    assert stage.ann.told[-1] is finished


async def test_a_number_that_was_had_is_refused_and_over_new_channels_all_begin_anew(stage: Stage) -> None:
    stage.ann.begin(5)
    stage.ann.push(4_800, 5)
    stage.ann.say(End(5))
    await stage.clock.advance(1.0)
    stage.ann.begin(5)
    stage.ann.begin(2)
    said = "utterance: must be greater than 5, the number of the last speech"
    assert stage.ann.told[-2:] == [Refused(5, said), Refused(2, said)]
    for _ in range(MALFORMED_LIMIT):
        stage.ann.sink.input_came("speech", "{}")
    stage.ann.sink.input_lost("the connection was lost")
    stage.ann.begin(1)
    stage.ann.push(4_800)
    stage.ann.say(End(1))
    await stage.clock.advance(1.0)
    assert stage.ann.told[-1] == Finished(1, 100)


async def test_too_many_frames_end_the_speech_and_clear_is_heard_all_the_same(stage: Stage) -> None:
    stage.ann.begin()
    for _ in range(FRAMES_AT_ONCE):
        stage.ann.push(1)
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert finished.reason.startswith("more than 500 frames and messages a second came: send longer ones")
    stage.ann.say(Clear(2))
    await stage.clock.advance(1.0)
    stage.ann.begin(2)
    assert stage.ann.told[-1] == Refused(2, "the speech was cleared")


async def test_words_may_be_of_sound_that_comes_later_and_text_grows_by_what_it_lacks(stage: Stage) -> None:
    stage.ann.begin()
    stage.ann.say(Words(1, (TimedWord("Hello", 0), TimedWord("you", 200)), (TimedWord("here", 100),)))
    stage.ann.push(24_000)
    await stage.clock.advance(1.0)
    assert stage.words() == [("Hello", 0), ("you", 6)]


async def test_a_word_that_the_text_lacks_moves_no_other_and_the_text_is_forgotten_as_it_is_found(stage: Stage) -> None:
    stage.ann.begin(text="one two three two")
    told = ("one", "oh", "two", "two", "ah")
    stage.ann.say(Words(1, tuple(TimedWord(word, 50 * number) for number, word in enumerate(told))))
    stage.ann.push(24_000)
    await stage.clock.advance(1.0)
    assert stage.words() == [("one", 0), ("oh", 18), ("two", 4), ("two", 14), ("ah", 21)]


async def test_more_words_than_are_spoken_end_the_speech(stage: Stage) -> None:
    stage.ann.begin()
    stage.ann.push(24_000)
    await stage.clock.advance(0.3)
    # Each is told at once, and none waits.
    for _ in range(WORDS_AT_ONCE // 200):
        stage.ann.say(Words(1, (TimedWord("a", 0),) * 200))
        await settle()
    assert len(stage.words()) == WORDS_AT_ONCE
    stage.ann.say(Words(1, (TimedWord("a", 0),)))
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert finished.reason.startswith(f"more than {WORDS_PER_SECOND:g} words and marks a second came: send fewer")
    assert len(stage.words()) == WORDS_AT_ONCE


async def test_too_many_words_end_the_speech(stage: Stage) -> None:
    stage.ann.begin()
    for _ in range(MOMENTS_LIMIT // 200 + 1):
        stage.ann.say(Words(1, (TimedWord("a", 0),) * 200))
        await stage.clock.advance(200 / WORDS_PER_SECOND)
        stage.ann.push(1)
        stage.voice.pause()
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert f"more than {MOMENTS_LIMIT} words and marks wait" in finished.reason


HAPPENING: dict[str, Callable[[Stage], object]] = {
    "the part is lent": lambda stage: stage.hold(stage.ann, 9, holds=False),
    "another application holds it": lambda stage: stage.hold(stage.bob, 9),
    "it holds it again": lambda stage: stage.hold(stage.ann, 9),
    "its adapter forgets it": lambda stage: stage.control.forget_client(stage.ann.client),
    "its channels close": lambda stage: stage.ann.sink.input_lost("the connection was lost"),
    "it is stopped": lambda stage: stage.control.interrupt("the speech was stopped"),
    "a person speaks": lambda stage: stage.voice.interrupt("a person spoke"),
    "it is suspended": lambda stage: stage.voice.pause(),
    "it is resumed": lambda stage: stage.voice.go_on(),
}
TIME = st.sampled_from([0.02, 0.5, 40.0])


@given(st.lists(st.one_of(ANYTHING, SPOKEN, SPOKEN, st.sampled_from(sorted(HAPPENING)), TIME), max_size=30))
@settings(deadline=None)
def test_whatever_comes_and_happens_each_speech_has_one_end_that_is_told(came: list[Any]) -> None:
    async def receive() -> None:
        async with TaskScope() as tasks:
            stage = Stage(tasks)
            begun: list[int] = []
            for each in came:
                if isinstance(each, str):
                    HAPPENING[each](stage)
                    if each == "its channels close":
                        # Nothing is told of what came over them, and all numbers are free again.
                        begun.clear()
                        stage.ann.told.clear()
                elif isinstance(each, float):
                    await stage.clock.advance(each)
                else:
                    newest = max(begun, default=-1)
                    begun += [message.utterance for message in begins(each) if message.utterance > newest]
                    stage.ann.sink.input_came(*each)
                await settle()
                assert stage.control.streams <= STREAMS_AT_ONCE
            stage.voice.go_on()
            await settle()
            # One for which no more sound comes is not waited for, though others wait before it.
            await stage.clock.advance((DRY_LIMIT + 2) * (len(begun) + 1))
            assert stage.control.streams == 0
            told = [each for each in stage.ann.told if not is_stray(each)]
            ends = [each.utterance for each in told if isinstance(each, Finished | Refused)]
            assert sorted(ends) == sorted(begun)
            for number in begun:
                assert isinstance([each for each in told if each.utterance == number][-1], Finished | Refused)

    asyncio.run(receive())


def begins(came: tuple[str, str | bytes]) -> list[Begin]:
    """The message of a beginning, if it is one."""
    label, data = came
    with suppress(InputError):
        message = read_speech(data) if label == "speech" and isinstance(data, str) else None
        return [message] if isinstance(message, Begin) else []
    return []


def is_stray(told: SpeechTold) -> bool:
    """Whether it is about frames that no speech began for, or a number that was had."""
    return isinstance(told, Refused) and any(each in told.reason for each in ("before its first frame", "greater than"))


@pytest.mark.parametrize(
    ("format", "sound", "reason"),
    [
        ("pcm16", b"\0\0\0", "a frame has whole samples of 2 bytes, not 3 bytes"),
        ("opus", b"\xff" * 200, "a packet of Opus cannot be decoded"),
    ],
)
async def test_sound_that_cannot_be_read_ends_its_speech_alone(
    stage: Stage, format: SpeechFormat, sound: bytes, reason: str
) -> None:
    stage.ann.say(Begin(1, format, 48_000))
    stage.ann.sink.input_came("speech", pack_frame(Frame(1, 0, sound)))
    stage.ann.begin(2)
    stage.ann.push(4_800, 2)
    stage.ann.say(End(2))
    await stage.clock.advance(1.0)
    first, second = (each for each in stage.ann.told if isinstance(each, Finished))
    assert (first.utterance, first.position) == (1, 0)
    assert first.reason.startswith(reason)
    assert second == Finished(2, 100)


@pytest.mark.parametrize("sequence", [0, 1, 3, 2**32 - 1])
async def test_a_frame_that_is_repeated_early_or_late_ends_the_speech(stage: Stage, sequence: int) -> None:
    stage.ann.begin()
    stage.ann.push(960)
    stage.ann.sink.input_came("speech", pack_frame(Frame(1, sequence, b"\0\0")))
    await settle()
    finished = stage.ann.told[-1]
    assert isinstance(finished, Finished)
    assert finished.reason.startswith(f"frame {sequence} came where 2 was due")


async def test_the_component_stops_streams_alone_and_counts(stage: Stage) -> None:
    registry = LocalRegistry("avatar", [SpeechStream(stage.control)])
    text = stage.say("one")
    stage.ann.begin()
    await settle()
    results = {each.name: each.value for each in await registry.query(REF, "streaming")}
    assert results["speeches"] == "1"
    await registry.invoke(REF, "stop")
    await settle()
    assert stage.ann.told == [Finished(1, 0, "the speech was stopped before its first sound")]
    assert not text.done()
    await stage.clock.advance(1.5)
    await text
