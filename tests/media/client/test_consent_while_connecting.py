"""Consent that is stated while a stream is being connected counts, and not what the engine was asked with before."""

import asyncio
import json
from collections.abc import Iterable
from typing import Any, cast

import pytest
from openrois_media.client.sending import Sending, consenting
from openrois_media.client.stream import SentStream
from openrois_media.client.stream_state import Desire
from openrois_media.client.streams import Streams
from openrois_streaming.source.source import RawAudio

from openrois.client import Client, ConnectionState, RoISError, Unsupported
from openrois.types.codes import Purpose
from openrois.types.messages import Parameter
from tests.support.streaming import FedSource, VirtualClock, settle

LIVE, AGENT, NOTHING = (Purpose.LIVE,), (Purpose.AGENT,), ()


class SlowGateway:
    """A gateway whose answers to `connect_stream` the test gives; it notes what else it is asked."""

    state = ConnectionState.CONNECTED

    def __init__(self) -> None:
        self.asked: list[tuple[str, Any]] = []
        self.answers: asyncio.Queue[str] = asyncio.Queue()
        self.refusal: RoISError | None = None

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
