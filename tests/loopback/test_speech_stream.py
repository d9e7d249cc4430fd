"""Speech as a stream, whole: an application's sound through gateway, adapter and WebRTC, as its viewer hears it."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.link.messages import Silence, Speak
from openrois_signaling.messages import Offer
from openrois_streaming.input.reader import MALFORMED_LIMIT
from openrois_streaming.input.speech import (
    FRAME_HEAD,
    Begin,
    Clear,
    End,
    Finished,
    Frame,
    Refused,
    SpeechTold,
    Starved,
    Words,
    pack_frame,
    read_told,
)
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.testing import MeasuringSink
from openrois_streaming.testing.input_sender import InputSender

from openrois.gateway.server import Gateway
from tests.support.deployment import Application, application
from tests.support.operated import NotingEngine, operated_avatar

pytestmark = pytest.mark.media

REF = "avatar/speech_stream"
LOUD = 1000


@dataclass
class Program:
    """An application that hears the avatar, and may speak through it."""

    app: Application
    sink: MeasuringSink
    blocks: list[RawAudio] = field(default_factory=list)

    @property
    def channels(self) -> InputSender:
        assert self.sink.input is not None
        return self.sink.input

    async def bind(self) -> None:
        assert await self.app.code("rois.command.bind", component_ref=REF) == "OK"
        # What the adapter is asked behind the binding it answers when it knows of that.
        await self.app.ask("rois.query.query", query_type="streaming", condition=f"component_ref = '{REF}'")

    def say(self, message: Begin | Words | End) -> None:
        self.channels.speak(json.dumps(message.to_json()))

    def clear(self, number: int) -> None:
        self.channels.send(json.dumps(Clear(number).to_json()), over_control=True)

    def push(self, number: int, sequence: int, sound: bytes) -> None:
        self.channels.speak(pack_frame(Frame(number, sequence, sound)))

    def told(self) -> list[SpeechTold | None]:
        return [read_told(text) for text in self.channels.told]

    async def until_told(self, kind: type[SpeechTold]) -> Any:
        def found() -> list[Any]:
            return [each for each in self.told() if isinstance(each, kind)]

        await self.sink.until(found)
        return found()[-1]

    def heard(self) -> float:
        """Seconds from the first loud sample that was heard to the last one."""
        loud = [
            block.captured_at + index / 48_000
            for block in self.blocks
            for index in np.flatnonzero(np.abs(block.samples[:, 0]) > LOUD)
        ]
        return max(loud) - min(loud) if loud else 0.0

    @property
    def made_up(self) -> float:
        """Seconds of sound that had not come in time: a viewer on a busy machine goes on with what it heard last."""
        return self.sink.received("0").concealed

    async def until(self, so: Callable[[], object]) -> None:
        await self.sink.until(so)


@dataclass
class House:
    gateway: Gateway
    engine: NotingEngine

    @asynccontextmanager
    async def program(self) -> AsyncIterator[Program]:
        blocks: list[RawAudio] = []

        def take(media: RawVideo | RawAudio) -> None:
            if isinstance(media, RawAudio):
                blocks.append(media)

        async with MeasuringSink(on_media=take) as sink, application(self.gateway) as app:
            await app.ask("openrois.hello", version="1", extensions=[])
            wish = json.dumps({"direction": "recvonly", "speech": True})
            parameter = {"name": "transport_parameters", "data_type_ref": "String", "value": wish}
            asked: dict[str, Any] = {"component_ref": "avatar/audio_streaming", "parameters": [parameter]}
            assert await app.code("rois.stream.connect_stream", **asked) == "OK"
            offer = Offer.model_validate(await app.next("signaling.offer"))
            assert await app.code("signaling.answer", **(await sink.respond(offer)).wire()) == "OK"
            await sink.until(lambda: sink.input is not None and sink.input.are_open)
            await sink.hears(20)
            yield Program(app, sink, blocks)


@pytest.fixture
async def house(tmp_path: Path) -> AsyncIterator[House]:
    async with operated_avatar(tmp_path) as (running, engine):
        yield House(running, engine)


def tone(seconds: float, rate: int) -> NDArray[np.int16]:
    moments = np.arange(round(seconds * rate)) / rate
    return np.asarray(np.rint(np.sin(2 * np.pi * 300 * moments) * 12_000), np.int16)


@pytest.mark.parametrize("rate", [16_000, 48_000])
async def test_what_is_pushed_is_heard_and_the_mouth_moves_with_it(house: House, rate: int) -> None:
    async with house.program() as program:
        await program.bind()
        program.say(Begin(1, "pcm16", rate))
        for sequence, part in enumerate(np.array_split(tone(0.9, rate), 30)):
            program.push(1, sequence, part.tobytes())
        program.say(End(1))
        finished = await program.until_told(Finished)
        assert finished == Finished(1, 900)
        # A busy machine loses some of what is heard, and makes some up.
        await program.until(lambda: program.heard() > 0.6)
        assert program.heard() < 1.0 + program.made_up
        assert house.engine.times(Speak)


async def test_opus_is_heard_and_running_dry_is_told(house: House) -> None:
    async with house.program() as program:
        await program.bind()
        program.say(Begin(1, "opus", 48_000))
        encoder = OpusEncoder(bitrate=32_000)
        chunks = encoder.encode(RawAudio(tone(0.4, 48_000)[:, np.newaxis], 0.0), key_frame=False)
        for sequence, chunk in enumerate(chunks):
            program.push(1, sequence, chunk.data)
        assert await program.until_told(Starved) == Starved(1, 400)
        await program.until(lambda: program.heard() > 0.35)


async def test_clear_silences_it_at_once_and_tells_what_was_heard(house: House) -> None:
    async with house.program() as program:
        await program.bind()
        program.say(Begin(1, "pcm16", 24_000))
        for sequence, part in enumerate(np.array_split(tone(1.0, 24_000), 50)):
            program.push(1, sequence, part.tobytes())
        await program.until(lambda: program.heard() > 0.2)
        program.clear(1)
        finished = await program.until_told(Finished)
        assert finished.reason.startswith("the speech was cleared")
        assert 200 <= finished.position < 1000
        await house.engine.until(lambda: house.engine.times(Silence))
        count = len(program.blocks)
        await program.until(lambda: len(program.blocks) > count + 30)
        assert 0.2 < program.heard() < finished.position / 1000 + 0.1 + program.made_up


async def test_only_the_application_that_has_bound_it_speaks_and_its_release_ends_the_speech(house: House) -> None:
    async with house.program() as ann, house.program() as bob:
        await ann.bind()
        bob.say(Begin(1, "pcm16", 16_000))
        bob.push(1, 0, tone(0.1, 16_000).tobytes())
        refused = await bob.until_told(Refused)
        assert (refused.utterance, refused.reason.startswith(f"{REF} has to be bound first")) == (1, True)
        ann.say(Begin(1, "pcm16", 16_000))
        ann.push(1, 0, tone(0.1, 16_000).tobytes())
        await ann.until_told(Starved)
        assert await ann.app.code("rois.command.release", component_ref=REF) == "OK"
        finished = await ann.until_told(Finished)
        # Of sound at 16 kHz 2 ms are kept until what follows them has come.
        assert (finished.position, finished.reason.startswith("the component was released")) == (98, True)
        await bob.bind()
        bob.say(Begin(2, "pcm16", 16_000))
        bob.push(2, 0, tone(0.1, 16_000).tobytes())
        bob.say(End(2))
        assert await bob.until_told(Finished) == Finished(2, 100)


async def test_a_flood_of_one_without_the_right_to_speak_does_not_interrupt_the_one_that_has_it(house: House) -> None:
    async with house.program() as ann, house.program() as bob:
        await ann.bind()
        ann.say(Begin(1, "pcm16", 48_000))
        for number in range(1, 1_200):
            bob.say(Begin(number, "pcm16", 48_000))
            bob.push(number, 0, bytes(2_000))
        bob.channels.speak(b"\xff" * 4_096)
        for sequence, part in enumerate(np.array_split(tone(0.5, 48_000), 25)):
            ann.push(1, sequence, part.tobytes())
        ann.say(End(1))
        assert await ann.until_told(Finished) == Finished(1, 500)
        await bob.until_told(Refused)
        condition = f"component_ref = '{REF}'"
        told = await ann.app.ask("rois.query.query", query_type="streaming", condition=condition)
        figures = {each["name"]: int(each["value"]) for each in told["results"]}
        assert figures["taken"] == 25
        assert figures["refused"] > 0


def beyond_credit(program: Program) -> None:
    for sequence in range(200):
        program.push(1, sequence, bytes(1_920))


def wrong_lengths(program: Program) -> None:
    for _ in range(MALFORMED_LIMIT):
        program.channels.speak(bytes(FRAME_HEAD.size))


def begins_and_clears(program: Program) -> None:
    for number in range(2, 2_002):
        program.clear(number - 1)
        program.say(Begin(number, "pcm16", 48_000))


@pytest.mark.parametrize(
    ("flood", "reason"),
    [
        (beyond_credit, "were granted: wait for credit"),
        (wrong_lengths, "32 messages could not be read, the last one: a frame has 9 to 4096 bytes, not 8"),
        (begins_and_clears, "the speech was cleared"),
    ],
)
async def test_a_flood_of_the_one_that_may_speak_ends_its_own_speech_and_nothing_else(
    house: House, flood: Callable[[Program], None], reason: str
) -> None:
    async with house.program() as ann, house.program() as bob:
        await ann.bind()
        ann.say(Begin(1, "pcm16", 48_000))
        flood(ann)
        assert reason in (await ann.until_told(Finished)).reason
        heard = len(bob.blocks)
        await bob.until(lambda: len(bob.blocks) > heard + 20)
        assert await ann.app.code("rois.command.release", component_ref=REF) == "OK"
        await bob.bind()
        bob.say(Begin(1, "pcm16", 48_000))
        for sequence, part in enumerate(np.array_split(tone(0.5, 48_000), 25)):
            bob.push(1, sequence, part.tobytes())
        bob.say(End(1))
        assert await bob.until_told(Finished) == Finished(1, 500)


async def test_frames_of_speeches_that_have_not_begun_are_dropped_and_those_of_one_that_has_are_played(
    house: House,
) -> None:
    async with house.program() as ann:
        await ann.bind()
        for number in range(300):
            ann.push(number, 0, bytes(1_920))
        ann.say(Begin(300, "pcm16", 48_000))
        for sequence, part in enumerate(np.array_split(tone(0.5, 48_000), 25)):
            ann.push(300, sequence, part.tobytes())
        ann.say(End(300))
        assert await ann.until_told(Finished) == Finished(300, 500)
        assert Refused(0, "a speech has to begin before its first frame") in ann.told()
        told = await ann.app.ask("rois.query.query", query_type="streaming", condition=f"component_ref = '{REF}'")
        figures = {each["name"]: int(each["value"]) for each in told["results"]}
        assert (figures["taken"], figures["dropped"]) == (25, 300)


async def test_a_speech_ends_with_the_connection_of_its_application(house: House) -> None:
    async with house.program() as listener, house.program() as ann:
        await ann.bind()
        ann.say(Begin(1, "pcm16", 16_000))
        ann.push(1, 0, tone(0.1, 16_000).tobytes())
        await ann.until_told(Starved)
        await ann.sink.__aexit__()
        condition = f"component_ref = '{REF}'"
        async with asyncio.timeout(30):
            while True:
                told = await listener.app.ask("rois.query.query", query_type="streaming", condition=condition)
                if {each["name"]: each["value"] for each in told["results"]}["speeches"] == "0":
                    break
