"""What an application speaks by sound ends with its right to: real gateway and adapter in memory, without a network."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

import numpy as np
import pytest
from openrois_body.body import Body
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speech_control import SpeechControl
from openrois_body.speech.voice import Voice
from openrois_media.streaming_interface import StreamingInterface
from openrois_streaming.clock import SystemClock
from openrois_streaming.input.speech import Begin, Finished, Frame, Refused, SpeechTold, pack_frame, read_told

from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from tests.openrois.gateway.test_adapter_latch import AGENT, ANN, application, attached, gateway
from tests.support.authorization import Wire
from tests.support.voice import ScriptedSynthesizer

REF = "robot/speech_stream"
SPEECH = {"component_ref": REF}
LATCHED = {"engine_id": "robot"}


@dataclass
class Stage:
    """A program that speaks by sound, a person, and the adapter's end of both."""

    control: SpeechControl
    ann: Wire
    agent: Wire
    told: list[SpeechTold] = field(default_factory=list)
    number: int = 0

    async def bind(self, app: Wire) -> None:
        assert await app.code("rois.command.bind", SPEECH) == "OK"
        await self.known()

    async def known(self) -> None:
        """Wait until the adapter knows who holds the component: notifications are in order with queries."""
        condition = {"query_type": "streaming", "condition": f"component_ref = '{REF}'"}
        assert await self.ann.code("rois.query.query", condition) == "OK"

    def connect(self) -> None:
        """Open channels for the application that holds the component."""
        holder = self.control.holder
        assert holder is not None
        self.sink = self.control.speech_sink(holder, self._take)

    def _take(self, text: str) -> None:
        told = read_told(text)
        assert told is not None
        self.told.append(told)

    def begin(self) -> None:
        self.number += 1
        self.sink.input_came("speech", json.dumps(Begin(self.number, "pcm16", 48_000).to_json()))
        self.sink.input_came("speech", pack_frame(Frame(self.number, 0, np.full(2_000, 800, "<i2").tobytes())))

    async def silent(self) -> SpeechTold:
        """Wait until nothing is spoken; return what was told last."""
        async with asyncio.timeout(20):
            while self.control.streams:  # noqa: ASYNC110 - it tells of no event
                await asyncio.sleep(0)
        return self.told[-1]

    def is_refused(self) -> bool:
        """Begin a speech, and tell whether it is refused."""
        self.begin()
        return isinstance(self.told[-1], Refused) and self.told[-1].utterance == self.number


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    async with standing() as found:
        yield found


@asynccontextmanager
async def standing() -> AsyncIterator[Stage]:
    clock = SystemClock()
    async with TaskScope() as tasks:
        voice = Voice(ScriptedSynthesizer(), BodySound(clock), Body(lambda _command: None))
        control = SpeechControl(REF, voice, clock, tasks)
        streams = StreamingInterface("robot", {}, clock, speech=control)
        async with (
            streams.sessions,
            hosted("robot", SpeechStream(control), extension=streams) as adapter,
            gateway() as here,
            attached(here, adapter),
            application(here, ANN) as ann,
            application(here, AGENT) as agent,
        ):
            stage = Stage(control, ann, agent)
            await stage.bind(agent)
            stage.connect()
            stage.begin()
            assert control.streams == 1
            yield stage


def reason(told: SpeechTold) -> str:
    assert isinstance(told, Finished)
    return told.reason


async def test_what_a_program_says_ends_with_stop_by_a_person_and_no_more_is_heard_until_it_is_handed_back(
    stage: Stage,
) -> None:
    assert await stage.ann.code("openrois.stop_all", LATCHED) == "OK"
    assert reason(await stage.silent())
    await stage.known()
    for _ in range(100):
        assert stage.is_refused()
    assert stage.control.streams == 0
    refused = stage.told[-1]
    assert isinstance(refused, Refused)
    assert "a person has stopped the body for programs" in refused.reason
    assert await stage.ann.code("openrois.lease.release_stop", LATCHED) == "OK"
    await stage.known()
    assert not stage.is_refused()


async def test_it_ends_when_the_voice_is_lent_and_goes_on_when_that_comes_back(stage: Stage) -> None:
    speaker = stage.control.holder
    assert await stage.ann.code("openrois.lease.borrow", {**SPEECH, "duration_ms": 20_000}) == "OK"
    assert reason(await stage.silent())
    await stage.known()
    assert stage.is_refused()
    assert await stage.ann.code("rois.command.release", SPEECH) == "OK"
    async with asyncio.timeout(20):
        while stage.control.holder is not speaker:  # noqa: ASYNC110 - it tells of no event
            await asyncio.sleep(0)
    assert not stage.is_refused()


async def test_it_ends_with_the_release_and_with_the_application(stage: Stage) -> None:
    assert await stage.agent.code("rois.command.release", SPEECH) == "OK"
    assert reason(await stage.silent()).startswith("the component was released")
    assert stage.is_refused()
    await stage.bind(stage.agent)
    assert not stage.is_refused()
    assert stage.control.holder is not None
    stage.control.forget_client(stage.control.holder)
    assert reason(await stage.silent()).startswith("the application that spoke is gone")


async def test_it_ends_when_the_adapter_loses_its_gateway() -> None:
    async with standing() as stage:
        pass
    assert reason(await stage.silent())
