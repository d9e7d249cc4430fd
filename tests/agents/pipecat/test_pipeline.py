"""A pipeline of Pipecat in a real avatar: its own library, a real gateway, and no service of any cloud."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from openrois_agents.pipecat import BodyTransport, embodied
from openrois_agents.voice.speech_writer import MAX_WRITTEN
from openrois_media import Media
from openrois_media.client.speaking import Spoken
from pipecat.frames.frames import (
    EndFrame,
    ErrorFrame,
    Frame,
    InterruptionFrame,
    OutputAudioRawFrame,
    TTSSpeakFrame,
)
from pipecat.pipeline.pipeline import Pipeline
from pipecat.pipeline.worker import PipelineWorker
from pipecat.processors.aggregators.llm_context import LLMContext
from pipecat.processors.aggregators.llm_response_universal import (
    LLMContextAggregatorPair,
    LLMUserAggregatorParams,
)
from pipecat.turns.user_turn_strategies import ExternalUserTurnStrategies
from pipecat.workers.runner import WorkerRunner

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.agent_house import agent_and_visitor, house, token
from tests.support.loopback import PATIENCE
from tests.support.pipecat_services import Beeps, Downstream, Note, Pitches, Rules
from tests.support.sounds import tone
from tests.support.voice_agents import Ear, Mouth, hearing

pytestmark = [pytest.mark.agents, pytest.mark.media]

HELLO, STOP = 500.0, 1_500.0
WORDS = {HELLO: "hello", STOP: "stop"}
STORY = " ".join(f"I tell you story {number}." for number in range(20))
ANSWERS = {"hello": STORY, "stop": "I am quiet."}
PER_WORD = 0.3
NEAR = 1.0
"""Seconds of what a body says that a viewer on a busy machine loses, or stretches; what the body tells is exact."""
CHUNK = 0.05
"""Seconds of a frame of sound, and a little more."""
SENTENCE = 5 * PER_WORD
TOLD = 20 * SENTENCE
"""Seconds of the story."""


class Conversation:
    """A pipeline in an avatar, and its visitor.

    Attributes:
        worker: it runs.
        transport: of the pipeline.
        told: what the output pushes on.
        spoken: what the body says of each speech.
        errors: of the pipeline.
        context: of the language model.
        pitches: recognises what the visitor says.
        rules: answers.
        ear: hears the avatar.
        mouth: of the visitor.
        sending: what the visitor sends.
    """

    worker: PipelineWorker
    transport: BodyTransport
    told: Downstream
    ear: Ear
    sending: Any

    def __init__(self) -> None:
        self.spoken: list[Spoken] = []
        self.errors: list[str] = []
        self.context = LLMContext()
        self.pitches = Pitches(WORDS)
        self.rules = Rules(ANSWERS)
        self.mouth = Mouth()

    @property
    def said(self) -> list[str]:
        """What the context has of the agent."""
        return [str(each["content"]) for each in self.context.get_messages() if each["role"] == "assistant"]

    def count(self, kind: type) -> int:
        """How many frames of a kind the output has pushed on."""
        return sum(isinstance(each, kind) for each in self.told.frames)


@asynccontextmanager
async def conversation(url: str, **tokens: str) -> AsyncIterator[Conversation]:
    talk = Conversation()
    async with (
        asyncio.timeout(PATIENCE),
        Client(url, token=tokens.get("visitor")) as theirs,
        Media(theirs) as their_media,
        their_media.send(microphone=talk.mouth, consent=[Purpose.AGENT, Purpose.LIVE]) as talk.sending,
        hearing(their_media) as talk.ear,
        Client(url, token=tokens.get("agent")) as client,
        Media(client) as media,
        embodied(client, media, "avatar", purposes=[Purpose.AGENT]) as talk.transport,
    ):
        talk.told = Downstream(talk.transport.output())
        aggregators = LLMContextAggregatorPair(
            talk.context, user_params=LLMUserAggregatorParams(user_turn_strategies=ExternalUserTurnStrategies())
        )
        aggregators.assistant().add_event_handler("on_assistant_turn_stopped", talk.told.notify)
        talk.transport.output()._writer.finished.add(talk.spoken.append)
        talk.transport.add_event_handler("on_client_disconnected", lambda *_: talk.pitches.forget())
        worker = talk.worker = PipelineWorker(
            Pipeline(
                [
                    talk.transport.input(),
                    talk.pitches,
                    aggregators.user(),
                    talk.rules,
                    Beeps(PER_WORD),
                    talk.transport.output(),
                    aggregators.assistant(),
                ]
            ),
            enable_rtvi=False,
            observers=[talk.told],
        )

        def note_error(_: PipelineWorker, error: ErrorFrame) -> None:
            talk.errors.append(error.error)
            talk.told.notify()

        worker.add_event_handler("on_pipeline_error", note_error)
        runner = WorkerRunner(handle_sigint=False)
        await runner.add_workers(worker)
        running = asyncio.create_task(runner.run())
        started = asyncio.Event()
        worker.add_event_handler("on_pipeline_started", lambda *_: started.set())
        try:
            await started.wait()
            yield talk
        finally:
            await runner.cancel()
            await running


async def test_a_visitor_is_heard_and_the_answer_is_told_as_it_is_heard(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: talk.told.steps)
        # The sound is told of when it was heard, and not when the voice has made it.
        assert talk.told.seconds < 3 * PER_WORD
        await talk.told.until(lambda: len(talk.told.steps) > 1)
        assert talk.told.seconds == pytest.approx(3 * PER_WORD, abs=0.08)
        assert talk.told.steps == ["started", "stopped"]
        assert talk.rules.asked == ["stop"]
        await talk.told.until(lambda: talk.said)
        assert talk.said == ["I am quiet."]
        await talk.ear.until_quiet()
        assert talk.ear.loud == pytest.approx(3 * PER_WORD, abs=NEAR)
        assert talk.errors == []


async def test_an_interruption_silences_the_body_and_what_was_told_is_what_was_heard(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(HELLO, 0.6)
        await talk.ear.until_loud(2.0)
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: len(talk.told.steps) > 1)
        heard = talk.told.seconds
        assert talk.told.steps == ["started", "stopped"]
        assert talk.count(InterruptionFrame) == 2
        assert 1.9 < heard < TOLD - 1
        assert talk.spoken[0].interrupted
        assert heard == pytest.approx(talk.spoken[0].seconds, abs=CHUNK)
        await talk.told.until(lambda: len(talk.told.steps) > 3)
        assert talk.told.seconds == pytest.approx(heard + 3 * PER_WORD, abs=0.08)
        await talk.ear.until_quiet()
        assert talk.ear.loud == pytest.approx(talk.told.seconds, abs=NEAR)
        assert talk.rules.asked == ["hello", "stop"]
        await talk.told.until(lambda: len(talk.said) > 1)
        story, quiet = talk.said
        assert STORY.startswith(story)
        # The sentences that were heard to their end; the last one may have been about to end.
        assert heard / SENTENCE - 1.1 < story.count(".") < heard / SENTENCE + 0.1
        assert quiet == "I am quiet."
        assert talk.errors == []


async def test_what_comes_faster_than_it_is_heard_waits_and_is_cleared_at_once(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        writer = talk.transport.output()._writer
        await talk.worker.queue_frame(TTSSpeakFrame(" ".join(["word"] * 100)))
        await talk.told.until(lambda: talk.told.seconds > 1.0)
        assert writer.waiting <= MAX_WRITTEN
        # What was taken is what was heard, what the body has, and what waits.
        assert writer.written - talk.told.seconds <= MAX_WRITTEN + 1.3
        assert talk.told.steps == ["started"]
        await talk.worker.queue_frame(InterruptionFrame())
        await talk.told.until(lambda: len(talk.told.steps) > 1)
        assert writer.waiting == 0.0
        assert talk.told.seconds == pytest.approx(talk.spoken[0].seconds, abs=CHUNK)
        await talk.ear.until_quiet()
        assert talk.ear.loud == pytest.approx(talk.told.seconds, abs=NEAR)
        assert talk.told.seconds < 4.0
        assert talk.errors == []


async def test_the_end_of_the_pipeline_waits_until_all_was_heard(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        await talk.worker.queue_frames([TTSSpeakFrame("one two three four"), EndFrame()])
        await talk.told.until(lambda: talk.count(EndFrame))
        assert talk.told.steps == ["started", "stopped"]
        assert talk.told.seconds == pytest.approx(4 * PER_WORD, abs=0.08)
        await talk.ear.until_quiet()
        assert talk.ear.loud == pytest.approx(4 * PER_WORD, abs=NEAR)


async def test_sound_that_is_no_speech_is_heard_and_ends_without_being_told(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        jingle = tone(0.4, 24_000)
        await talk.worker.queue_frame(OutputAudioRawFrame(jingle.tobytes(), 24_000, 1))
        await talk.told.until(lambda: talk.told.seconds == pytest.approx(0.4))
        await talk.transport.output()._writer.until_over()
        assert talk.told.steps == []
        stereo = OutputAudioRawFrame(jingle.tobytes(), 24_000, 2)
        with pytest.raises(ValueError, match="sound of 2 channels is not spoken: mix it down to one first"):
            await talk.transport.output().write_audio_frame(stereo)


async def test_a_body_that_is_lost_in_mid_sentence_is_an_error_and_an_interruption(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(HELLO, 0.6)
        await talk.ear.until_loud(2.0)
        await there.lose_avatar()
        await talk.told.until(lambda: "stopped" in talk.told.steps)
        await talk.told.until(lambda: talk.errors)
        assert talk.errors[0].startswith("the body broke off what it said: ")
        await talk.told.until(lambda: talk.count(InterruptionFrame) == 2)
        await talk.told.until(lambda: talk.said)
        assert STORY.startswith(talk.said[0])
        assert len(talk.said[0]) < len(STORY)
        heard = talk.told.seconds
        assert heard < TOLD - 1
        # What is said to no body is an error each time, and told as not heard; the pipeline goes on.
        errors = len(talk.errors)
        await talk.worker.queue_frame(TTSSpeakFrame("Is anybody there?"))
        await talk.told.until(lambda: len(talk.errors) > errors)
        assert talk.told.steps == ["started", "stopped"]
        assert talk.told.seconds == heard


def has_ended(talk: Conversation, ends: int) -> bool:
    """Tell whether so many speeches have failed, or been heard after the first one."""
    return len(talk.errors) + len(talk.told.steps) // 4 >= ends


async def test_a_part_that_a_person_takes_breaks_off_the_answer_until_it_is_given_back(tmp_path: Path) -> None:
    async with (
        house(tmp_path, with_tokens=True) as there,
        conversation(there.url, **agent_and_visitor()) as talk,
        Client(there.url, token=token("ann", rank="person", roles=["operator"])) as person,
    ):
        talk.mouth.say(HELLO, 0.6)
        await talk.told.until(lambda: talk.told.seconds > 0.5)
        await person.control.borrow("avatar/speech_stream")
        await talk.told.until(lambda: "stopped" in talk.told.steps)
        heard = talk.told.seconds
        assert heard < TOLD - 1
        assert heard == pytest.approx(talk.spoken[0].seconds, abs=CHUNK)
        await talk.ear.until_quiet()
        assert talk.ear.loud == pytest.approx(heard, abs=NEAR)
        await talk.told.until(lambda: len(talk.errors) == 1 and talk.count(InterruptionFrame) == 2)
        await talk.worker.queue_frame(TTSSpeakFrame("May I?"))
        await talk.told.until(lambda: len(talk.errors) == 2 and talk.count(InterruptionFrame) == 3)
        assert (talk.told.steps, talk.told.seconds) == (["started", "stopped"], heard)
        await person.control.give_back("avatar/speech_stream")
        while talk.told.seconds == heard:
            ends = len(talk.errors) + len(talk.told.steps) // 4 + 1
            await talk.worker.queue_frame(TTSSpeakFrame("Thank you."))
            await talk.told.until(partial(has_ended, talk, ends))
        assert talk.told.steps == ["started", "stopped"] * 2
        assert talk.told.seconds == pytest.approx(heard + 2 * PER_WORD, abs=0.08)


async def test_words_of_a_visitor_that_withdraws_its_consent_are_not_answered(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        told: list[str] = []
        for event in ("on_client_connected", "on_client_disconnected"):
            talk.transport.add_event_handler(event, lambda _, ref, event=event: told.append(f"{event} {ref}"))
        talk.mouth.say(HELLO, 30.0)
        await talk.pitches.news.until(lambda: sum(talk.pitches.heard.values()) > 0.5)
        (visitor,) = talk.pitches.heard
        await talk.sending.consent(Purpose.LIVE)
        talk.mouth.hush()
        await talk.pitches.news.until(lambda: "" in talk.pitches.heard)
        heard = talk.pitches.heard[visitor]
        assert talk.transport.get_client_id(visitor) == visitor
        await talk.sending.consent(Purpose.AGENT)
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: "stopped" in talk.told.steps)
        assert talk.rules.asked == ["stop"]
        assert talk.pitches.heard[visitor] <= heard + 0.7
        assert talk.pitches.heard[""] == 0.0
        gone, back = f"on_client_disconnected {visitor}", f"on_client_connected {visitor}"
        assert told[-2:] == [gone, back]


async def test_without_purposes_the_pipeline_hears_nothing_and_speaks(tmp_path: Path) -> None:
    async with (
        house(tmp_path) as there,
        Client(there.url) as client,
        Media(client) as media,
        embodied(client, media, "avatar") as transport,
    ):
        told = Downstream(transport.output())
        pipeline = Pipeline([transport.input(), Beeps(PER_WORD), transport.output()])
        worker = PipelineWorker(pipeline, enable_rtvi=False, observers=[told])
        runner = WorkerRunner(handle_sigint=False)
        await runner.add_workers(worker)
        await worker.queue_frames([TTSSpeakFrame("one two"), EndFrame()])
        async with asyncio.timeout(PATIENCE):
            await runner.run()
        assert told.steps == ["started", "stopped"]
        assert told.seconds == pytest.approx(2 * PER_WORD, abs=0.08)


async def test_frames_behind_sound_wait_for_it_in_order_and_within_the_bound(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        behind = talk.transport.output()._behind
        notes: list[Frame] = [Note() for _ in range(1_200)]
        most = 0

        def count_behind() -> bool:
            nonlocal most
            most = max(most, len(behind))
            return talk.count(Note) == len(notes)

        await talk.worker.queue_frames([OutputAudioRawFrame(tone(0.8, 24_000).tobytes(), 24_000, 1), *notes])
        await talk.told.until(count_behind)
        assert 1_000 <= most <= 1_001
        ordered = [each for each in talk.told.frames if isinstance(each, Note | OutputAudioRawFrame)]
        assert ordered[-len(notes) :] == notes
        assert talk.told.seconds == pytest.approx(0.8)


async def test_sound_that_is_not_interruptible_is_heard_to_its_end(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        notice = OutputAudioRawFrame(tone(0.8, 24_000).tobytes(), 24_000, 1)
        notice.interruptible = False
        await talk.worker.queue_frame(notice)
        await talk.told.until(lambda: talk.told.seconds > 0.2)
        await talk.worker.queue_frame(InterruptionFrame())
        await talk.told.until(lambda: talk.count(InterruptionFrame))
        assert talk.told.seconds < 0.8 - CHUNK
        await talk.told.until(lambda: talk.told.seconds == pytest.approx(0.8))
