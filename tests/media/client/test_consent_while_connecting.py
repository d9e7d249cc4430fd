"""Consent that is stated while a stream is being connected counts, and not what the engine was asked with before."""

import asyncio
import json
from collections.abc import Iterable
from typing import Any, cast

import numpy as np
import pytest
from openrois_media.client.sending import Sending, consenting
from openrois_media.client.stream import SentStream
from openrois_media.client.stream_state import Desire
from openrois_media.client.streams import Streams
from openrois_streaming.source.source import RawAudio

from openrois.client import Client, ConnectionLost, ConnectionState, Unsupported
from openrois.types.codes import Purpose, StreamStatus
from openrois.types.messages import Parameter
from tests.support.streaming import FedSource, VirtualClock, settle

SILENCE = np.zeros((960, 1), np.int16)
LIVE, AGENT, NOTHING = (Purpose.LIVE,), (Purpose.AGENT,), ()


class Path:
    """A peer connection that carries a stream, and what is sent over it."""

    is_connected = True

    def __init__(self) -> None:
        self.sent: list[float] = []
        self.peer = self.section = self.outgoing = self

    def put(self, block: RawAudio) -> None:
        self.sent.append(block.captured_at)


class SlowGateway:
    """A gateway whose answers to `connect_stream` the test gives; it notes what else it is asked."""

    state = ConnectionState.CONNECTED

    def __init__(self) -> None:
        self.asked: list[tuple[str, Any]] = []
        self.answers: asyncio.Queue[str] = asyncio.Queue()
        self.refusal: Exception | None = None
        self.may_answer = asyncio.Event()
        self.may_answer.set()

    def notifications(self, *_methods: str, buffer: int) -> Any:
        return _nothing()

    def notices(self, *_kinds: type) -> Any:
        return _nothing()

    async def connect_stream(self, _component_ref: str, parameters: Iterable[Parameter]) -> str:
        (transport,) = (json.loads(each.value) for each in parameters if each.name == "transport_parameters")
        self.asked.append(("connect", transport["consent"]))
        return await self.answers.get()

    async def call(self, method: str, **params: Any) -> dict[str, Any]:
        if method == "rois.stream.set_consent":
            self.asked.append(("state", params["consent"]))
            await self.may_answer.wait()
            if self.refusal is not None:
                raise self.refusal
        elif method == "rois.stream.disconnect_stream":
            self.asked.append(("disconnect", params["stream_id"]))
        return {"visitor_ref": "urn:me"}


async def _nothing() -> Any:
    await asyncio.Event().wait()
    yield


@pytest.mark.parametrize("then", [NOTHING, AGENT])
async def test_what_is_stated_meanwhile_is_said_before_anything_is_sent(then: tuple[Purpose, ...]) -> None:
    gateway, clock = SlowGateway(), VirtualClock()
    async with Streams(cast(Client, gateway), clock) as streams:
        stream = SentStream("robot/ears", "audio", FedSource[RawAudio](), streams, clock, consenting(LIVE))
        sending = Sending([stream], cast(Client, gateway))
        streams.add(stream)
        stream.want(Desire.RUNNING)
        await settle()
        await sending.consent(*then)
        assert gateway.asked == [("connect", ["live"])]
        gateway.answers.put_nowait("robot/s1")
        await stream.established()
        assert gateway.asked == [("connect", ["live"]), ("state", list(then))]
        assert stream.state.stream_id == "robot/s1"


async def test_a_stream_whose_consent_cannot_be_stated_is_not_sent() -> None:
    gateway, clock = SlowGateway(), VirtualClock()
    gateway.refusal = Unsupported("gone")
    async with Streams(cast(Client, gateway), clock) as streams:
        stream = SentStream("robot/ears", "audio", FedSource[RawAudio](), streams, clock, consenting(LIVE))
        streams.add(stream)
        stream.want(Desire.RUNNING)
        await settle()
        await Sending([stream], cast(Client, gateway)).consent()
        gateway.answers.put_nowait("robot/s1")
        await settle()
        assert gateway.asked == [("connect", ["live"]), ("state", []), ("disconnect", "robot/s1")]
        assert stream.state.stream_id is None


@pytest.mark.parametrize("fails", [False, True])
async def test_nothing_is_sent_until_the_body_knows_what_may_be_done_with_it(
    monkeypatch: pytest.MonkeyPatch, fails: bool
) -> None:
    gateway, clock, source, path = SlowGateway(), VirtualClock(), FedSource[RawAudio](), Path()
    async with Streams(cast(Client, gateway), clock) as streams:
        stream = SentStream("robot/ears", "audio", source, streams, clock, consenting((*LIVE, *AGENT)))
        monkeypatch.setattr(stream.place, "attachments", lambda: [path])
        streams.add(stream)
        stream.want(Desire.RUNNING)
        gateway.answers.put_nowait("robot/s1")
        await stream.established()
        sending, reading = Sending([stream], cast(Client, gateway)), asyncio.ensure_future(stream.run_source())
        await settle()
        await source.feed(block(0.0))
        assert path.sent == [0.0]
        gateway.may_answer.clear()
        gateway.refusal = ConnectionLost("gone") if fails else None
        stating = asyncio.ensure_future(sending.consent(*LIVE))
        await settle()
        await source.feed(block(0.02))
        gateway.may_answer.set()
        await asyncio.wait({stating})
        await source.feed(block(0.04))
        # The source stays open meanwhile.
        assert source.opened == 1
        assert path.sent == ([0.0] if fails else [0.0, 0.04])
        assert (stating.exception() is not None) == fails
        if fails:
            # With the next connection it is told.
            stream.lost(StreamStatus.STREAMING_NOT_CONNECTED)
            stream.retry_now()
            gateway.answers.put_nowait("robot/s2")
            await stream.established()
            await source.feed(block(0.06))
            assert gateway.asked[-1] == ("connect", ["live"])
            assert path.sent == [0.0, 0.06]
        reading.cancel()
        await asyncio.wait({reading})


def block(at: float) -> RawAudio:
    return RawAudio(SILENCE, at)
