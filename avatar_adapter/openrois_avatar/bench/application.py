"""An application that plays one video stream at a measuring sink, as any other would: over the gateway, decoding it."""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

from openrois_streaming.testing import MeasuringSink, SeenPicture

from openrois.bench.errors import BenchFailed, within
from openrois.jsonrpc.session import RpcSession
from openrois.transport.websocket import dial

__all__ = ["Application", "Playing", "application"]

_PATIENCE: Final = 15.0
"""Seconds for an offer, or for a picture; a machine that needs longer cannot be measured."""
_WAITING: Final = 1024


class Playing:
    """A stream that plays."""

    def __init__(
        self, application: "Application", stream_id: str, pictures: asyncio.Queue[SeenPicture], asked_at: float
    ) -> None:
        self.asked_at = asked_at
        """Monotonic time at which the stream was asked for."""
        self._application = application
        self._stream_id = stream_id
        self._pictures = pictures

    async def picture(self) -> SeenPicture:
        """The next picture; none is left out.

        Raises:
            BenchFailed: none comes.
        """
        async with within(_PATIENCE, "the next picture"):
            return await self._pictures.get()

    async def ask(self, verb: str) -> None:
        """Have the stream do one of the streaming verbs."""
        await self._application.ask(f"rois.stream.{verb}_stream", stream_id=self._stream_id)


class Application:
    """A session at the gateway."""

    def __init__(self, session: RpcSession) -> None:
        self._session = session
        self._offers: asyncio.Queue[dict[str, Any]] = asyncio.Queue(16)
        self.bye = ""
        """Why the engine has ended a peer connection; empty where it has not."""
        session.notifications = {"signaling.offer": self._offers.put_nowait, "signaling.bye": self._bye}

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method and return its result.

        Raises:
            BenchFailed: the answer is not OK.
        """
        result: dict[str, Any] = await self._session.call(method, params)
        if result["return_code"] != "OK":
            raise BenchFailed(f"{method} was answered {result['return_code']}")
        return result

    def _bye(self, params: dict[str, Any]) -> None:
        self.bye = params["reason"]

    async def offered(self, component_ref: str, codec: str) -> tuple[str, dict[str, Any]]:
        """Connect a stream of a component; returns its id and the offer.

        Raises:
            BenchFailed: it is refused, or no offer comes.
        """
        encoding = {
            "name": "encoding_parameters",
            "data_type_ref": "string",
            "value": json.dumps({"codecs": [codec]}),
        }
        connected = await self.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=[encoding])
        async with within(_PATIENCE, "the offer"):
            return connected["stream_id"], await self._offers.get()

    async def answer(self, offer: dict[str, Any], sdp: str) -> None:
        """Answer an offer."""
        await self.ask("signaling.answer", peer_id=offer["peer_id"], generation=offer["generation"], sdp=sdp)

    @asynccontextmanager
    async def playing(self, component_ref: str, codec: str) -> AsyncIterator[Playing]:
        """Play the stream of a component for as long as the context lasts.

        Raises:
            BenchFailed: it is refused, or no offer comes.
        """
        asked_at = time.monotonic()
        stream_id, offer = await self.offered(component_ref, codec)
        pictures: asyncio.Queue[SeenPicture] = asyncio.Queue(_WAITING)
        async with MeasuringSink(on_picture=pictures.put_nowait) as sink:
            await self.answer(offer, await sink.answer(offer["sdp"]))
            yield Playing(self, stream_id, pictures, asked_at)
            await self.ask("rois.stream.disconnect_stream", stream_id=stream_id)


@asynccontextmanager
async def application(url: str) -> AsyncIterator[Application]:
    """Connect to the gateway at `url` (`ws://host:port/`) as an application, for as long as the context lasts."""
    async with dial(url) as stream:
        session = RpcSession(stream)
        connected = Application(session)
        running = asyncio.create_task(session.run(), name="application")
        try:
            await connected.ask("rois.system.connect")
            yield connected
        finally:
            await session.close()
            await asyncio.wait({running})
