"""A session of LiveKit Agents in a real avatar: its own library, a real gateway, and no service of any cloud."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from livekit.agents import Agent, AgentSession
from livekit.rtc import AudioFrame
from openrois_agents.livekit import embodied
from openrois_agents.livekit.audio_output import BodyAudioOutput
from openrois_agents.voice.speech_writer import MAX_WRITTEN, SpeechWriter
from openrois_media import Media
from openrois_media.client.stream import News

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.agent_house import agent_and_visitor, house, token
from tests.support.livekit_plugins import Beeps, Pitches, Rules
from tests.support.loopback import PATIENCE
from tests.support.sounds import tone
from tests.support.voice_agents import Ear, Mouth, hearing

pytestmark = [pytest.mark.agents, pytest.mark.media]

HELLO, STOP = 500.0, 1_500.0
WORDS = {HELLO: "hello", STOP: "stop"}
STORY = " ".join(f"word{number}" for number in range(20))
ANSWERS = {"hello": STORY, "stop": "I am quiet."}
STORY_PITCH, QUIET_PITCH = 300, 700
PER_WORD = 0.3
QUIET = pytest.approx(3 * PER_WORD, abs=0.05)
"""Seconds of the short answer; resampling adds a little silence."""


class Told:
    """What a session tells, as it comes.

    Attributes:
        steps: `started`, or how many seconds were heard and whether that was an interruption.
    """

    def __init__(self, session: AgentSession[Any]) -> None:
        self.steps: list[str | tuple[float, bool]] = []
        self._session = session
        self._news = News()
        output = session.output.audio
        output.on("playback_started", lambda _: self._note("started"))
        output.on("playback_finished", lambda end: self._note((round(end.playback_position, 2), end.interrupted)))
        session.on("conversation_item_added", lambda _: self._news.notify())
        session.on("agent_state_changed", lambda _: self._news.notify())

    def _note(self, step: str | tuple[float, bool]) -> None:
        self.steps.append(step)
        self._news.notify()

    @property
    def ends(self) -> list[tuple[float, bool]]:
        return [each for each in self.steps if isinstance(each, tuple)]

    @property
    def said(self) -> list[tuple[str, bool]]:
        """What the history has of the agent, and whether it was interrupted."""
        messages = self._session.history.messages()
        return [((each.text_content or "").strip(), each.interrupted) for each in messages if each.role == "assistant"]

    async def until(self, so: Callable[[], object]) -> None:
        async with asyncio.timeout(PATIENCE):
            await self._news.until(so)


class Conversation:
    """A session in an avatar, and its visitor.

    Attributes:
        session: it runs.
        told: what it tells.
        ear: hears the avatar.
        mouth: of the visitor.
        sending: what the visitor sends.
        asked: what the language model was asked.
    """

    def __init__(self, session: AgentSession[Any], told: Told, ear: Ear, mouth: Mouth, sending: Any) -> None:
        self.session = session
        self.told = told
        self.ear = ear
        self.mouth = mouth
        self.sending = sending

    @property
    def asked(self) -> list[str]:
        asked: list[str] = self.session.llm.asked
        return asked


@asynccontextmanager
async def conversation(url: str, **tokens: str) -> AsyncIterator[Conversation]:
    session: AgentSession[Any] = AgentSession(
        stt=Pitches(WORDS),
        llm=Rules(ANSWERS),
        tts=Beeps(PER_WORD, {STORY: STORY_PITCH, ANSWERS["stop"]: QUIET_PITCH}),
        vad=None,
        turn_handling={
            "turn_detection": "stt",
            "endpointing": {"min_delay": 0.1, "max_delay": 0.5},
            # A body does not pause.
            "interruption": {"resume_false_interruption": False},
            "preemptive_generation": {"enabled": False},
        },
        aec_warmup_duration=None,
        user_away_timeout=None,
    )
    mouth = Mouth()
    async with (
        asyncio.timeout(PATIENCE),
        Client(url, token=tokens.get("visitor")) as theirs,
        Media(theirs) as their_media,
        their_media.send(microphone=mouth, consent=[Purpose.AGENT, Purpose.LIVE]) as sending,
        hearing(their_media) as ear,
        Client(url, token=tokens.get("agent")) as client,
        Media(client) as media,
        embodied(session, client, media, "avatar", purposes=[Purpose.AGENT]),
    ):
        told = Told(session)
        await session.start(Agent(instructions="Answer."))
        try:
            yield Conversation(session, told, ear, mouth, sending)
        finally:
            await session.aclose()


async def test_a_visitor_is_heard_and_the_whole_answer_is_told_as_heard(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: talk.told.ends)
        await talk.told.until(lambda: talk.told.said)
        assert talk.asked == ["stop"]
        assert talk.told.steps == ["started", (QUIET, False)]
        assert talk.told.said == [("I am quiet.", False)]
        await talk.ear.until_quiet()
        assert talk.ear.seconds(QUIET_PITCH) == pytest.approx(3 * PER_WORD, abs=0.1)


async def test_an_interruption_silences_the_body_and_its_position_is_what_was_heard(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(HELLO, 0.6)
        await talk.ear.until_loud(2.0)
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: talk.told.ends)
        heard, interrupted = talk.told.ends[0]
        assert interrupted
        assert 1.9 < heard < 20 * PER_WORD
        await talk.told.until(lambda: len(talk.told.ends) > 1)
        await talk.told.until(lambda: len(talk.told.said) > 1)
        # A viewer hears it a little later, and what follows, too.
        await talk.ear.until_quiet()
        assert talk.ear.seconds(STORY_PITCH) == pytest.approx(heard, abs=0.1)
        assert talk.ear.seconds(QUIET_PITCH) == pytest.approx(3 * PER_WORD, abs=0.1)
        assert talk.asked == ["hello", "stop"]
        assert talk.told.ends[1] == (QUIET, False)
        (story, was_interrupted), quiet = talk.told.said
        assert was_interrupted
        assert STORY.startswith(story)
        assert len(story.split()) < 20
        assert quiet == ("I am quiet.", False)


async def test_a_body_that_is_lost_in_mid_sentence_ends_the_answer_as_interrupted(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(HELLO, 0.6)
        await talk.ear.until_loud(2.0)
        await there.lose_avatar()
        await talk.told.until(lambda: talk.told.ends)
        heard, interrupted = talk.told.ends[0]
        assert interrupted
        assert heard < 20 * PER_WORD
        await talk.told.until(lambda: talk.session.agent_state == "listening")
        await talk.told.until(lambda: talk.told.said)
        assert talk.told.said[0][1]
        # What is said to no body is told as not heard, and the session goes on.
        await talk.session.say("Is anybody there?")
        assert talk.told.ends[1:] == [(0.0, True)]


async def test_a_part_that_a_person_takes_breaks_off_the_answer_until_it_is_given_back(tmp_path: Path) -> None:
    async with (
        house(tmp_path, with_tokens=True) as there,
        conversation(there.url, **agent_and_visitor()) as talk,
        Client(there.url, token=token("ann", rank="person", roles=["operator"])) as person,
    ):
        talk.mouth.say(HELLO, 0.6)
        await talk.told.until(lambda: "started" in talk.told.steps)
        await person.control.borrow("avatar/speech_stream")
        await talk.told.until(lambda: talk.told.ends)
        heard, interrupted = talk.told.ends[0]
        assert interrupted
        assert heard < 20 * PER_WORD
        await talk.ear.until_quiet()
        assert talk.ear.seconds(STORY_PITCH) == pytest.approx(heard, abs=0.1)
        await talk.session.say("May I?")
        assert talk.told.ends[1:] == [(0.0, True)]
        await person.control.give_back("avatar/speech_stream")
        while talk.told.ends[-1][1]:
            await talk.session.say("Thank you.")
        assert talk.told.ends[-1] == (pytest.approx(2 * PER_WORD, abs=0.05), False)


async def test_words_of_a_visitor_that_withdraws_its_consent_are_not_answered(tmp_path: Path) -> None:
    async with house(tmp_path) as there, conversation(there.url) as talk:
        talk.mouth.say(HELLO, 30.0)
        states = News()
        talk.session.on("user_input_transcribed", lambda _: states.notify())
        recognition = talk.session.stt
        await states.until(lambda: recognition.heard > 0.5)
        await talk.sending.consent(Purpose.LIVE)
        talk.mouth.hush()
        sound = talk.session.input.audio._sound
        left = News()
        sound.heard_changed.add(lambda _: left.notify())
        await left.until(lambda: not sound.heard)
        await talk.sending.consent(Purpose.AGENT)
        await left.until(lambda: sound.heard)
        talk.mouth.say(STOP, 0.6)
        await talk.told.until(lambda: talk.told.said)
        assert talk.asked == ["stop"]


async def test_what_is_captured_faster_than_it_is_heard_waits_and_is_cleared_at_once(tmp_path: Path) -> None:
    async with (
        house(tmp_path) as there,
        Client(there.url) as client,
        Media(client) as media,
        media.speech("avatar", rate=24_000) as speech,
        SpeechWriter(speech) as writer,
    ):
        output = BodyAudioOutput(writer)
        sound = tone(8.0, 24_000)

        async def capture() -> None:
            for first in range(0, len(sound), 480):
                await output.capture_frame(AudioFrame(sound[first : first + 480].tobytes(), 24_000, 1, 480))
            output.flush()

        started = asyncio.Event()
        output.on("playback_started", lambda _: started.set())
        capturing = asyncio.create_task(capture())
        await started.wait()
        assert not capturing.done()
        assert writer.waiting <= MAX_WRITTEN
        output.clear_buffer()
        assert writer.waiting == 0.0
        await capturing
        end = await output.wait_for_playout()
        assert end.interrupted
        assert end.playback_position < 8.0
        # Segments without sound, and of other sound.
        await output.capture_frame(AudioFrame(b"", 24_000, 1, 0))
        output.flush()
        assert not (await output.wait_for_playout()).interrupted
        stereo = np.repeat(sound[:2_400], 2)
        await output.capture_frame(AudioFrame(stereo.tobytes(), 24_000, 2, 2_400))
        output.flush()
        assert (await output.wait_for_playout()).playback_position == pytest.approx(0.1)
        with pytest.raises(ValueError, match="frames must have 24000 Hz, not 48000: resample them first"):
            await output.capture_frame(AudioFrame(b"ab", 48_000, 1, 1))


async def test_a_session_that_outlives_its_body_is_interrupted_and_goes_on_without_ears_and_mouth(
    tmp_path: Path,
) -> None:
    session: AgentSession[Any] = AgentSession(tts=Beeps(PER_WORD, {}), vad=None, user_away_timeout=None)
    async with house(tmp_path) as there, asyncio.timeout(PATIENCE), Client(there.url) as client, Media(client) as media:
        async with embodied(session, client, media, "avatar", purposes=[Purpose.AGENT]):
            told = Told(session)
            await session.start(Agent(instructions="Say."))
            speech = session.say(STORY)
            await told.until(lambda: told.steps)
        await speech
        assert speech.interrupted
        assert (session.input.audio, session.output.audio, session.output.transcription) == (None, None, None)
        assert [interrupted for _, interrupted in told.ends] == [True]
        await session.aclose()
