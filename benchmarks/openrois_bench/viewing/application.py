"""An application that plays one video stream at a measuring sink, as any other would: over the gateway, decoding it."""

import asyncio
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Any, Final

from openrois_streaming.testing import MeasuringSink, SeenPicture

from openrois.client import Client
from openrois.client.components import VideoStreaming
from openrois.errors import RoISError
from openrois_bench.errors import BenchFailed, within

__all__ = ["Application", "Playing", "application"]

_PATIENCE: Final = 15.0
"""Seconds for an offer, or for a picture; a machine that needs longer cannot be measured."""
_WAITING: Final = 1024


class Playing:
    """A stream that plays."""

    def __init__(
        self, component: VideoStreaming, stream_id: str, pictures: asyncio.Queue[SeenPicture], asked_at: float
    ) -> None:
        self.asked_at = asked_at
        """Monotonic time at which the stream was asked for."""
        self._component = component
        self._stream_id = stream_id
        self._pictures = pictures

    async def picture(self) -> SeenPicture:
        """The next picture; none is left out.

        Raises:
            BenchFailed: none comes.
        """
        async with within(_PATIENCE, "the next picture"):
            return await self._pictures.get()

    async def suspend(self) -> None:
        """Suspend the stream."""
        with _not_refused("suspend_stream"):
            await self._component.suspend_stream(self._stream_id)

    async def resume(self) -> None:
        """Resume the stream."""
        with _not_refused("resume_stream"):
            await self._component.resume_stream(self._stream_id)


class Application:
    """A client whose streams are negotiated here."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._offers = client.notifications("signaling.offer")
        self.bye = ""
        """Why the engine has ended a peer connection; empty where it has not."""

    async def listen(self) -> None:
        """Note when the engine ends a peer connection, until the client is closed."""
        async for told in self._client.notifications("signaling.bye"):
            self.bye = told.params["reason"]

    async def offered(self, component_ref: str, codec: str) -> tuple[str, dict[str, Any]]:
        """Connect a stream of a component; returns its id and the offer.

        Raises:
            BenchFailed: it is refused, or no offer comes.
        """
        with _not_refused("connect_stream"):
            stream_id = await self._component(component_ref).connect_stream(encoding={"codecs": [codec]})
        async with within(_PATIENCE, "the offer"):
            return stream_id, (await anext(self._offers)).params

    async def answer_offer(self, offer: dict[str, Any], sdp: str) -> None:
        """Answer an offer."""
        with _not_refused("signaling.answer"):
            await self._client.call(
                "signaling.answer", peer_id=offer["peer_id"], generation=offer["generation"], sdp=sdp
            )

    @asynccontextmanager
    async def playing(self, component_ref: str, codec: str) -> AsyncIterator[Playing]:
        """Play the stream of a component for as long as the context lasts.

        Raises:
            BenchFailed: it is refused, or no offer comes.
        """
        asked_at = time.monotonic()
        stream_id, offer = await self.offered(component_ref, codec)
        component, pictures = self._component(component_ref), asyncio.Queue[SeenPicture](_WAITING)
        async with MeasuringSink(on_picture=pictures.put_nowait) as sink:
            await self.answer_offer(offer, await sink.answer(offer["sdp"]))
            yield Playing(component, stream_id, pictures, asked_at)
            await component.disconnect_stream(stream_id)

    def _component(self, component_ref: str) -> VideoStreaming:
        return self._client.component(VideoStreaming, component_ref)


@contextmanager
def _not_refused(what: str) -> Iterator[None]:
    try:
        yield
    except RoISError as error:
        raise BenchFailed(f"{what} was refused: {error}") from error


@asynccontextmanager
async def application(url: str) -> AsyncIterator[Application]:
    """Connect to the gateway at `url` (`ws://host:port/`) as an application, for as long as the context lasts."""
    async with Client(url, reconnect=None) as client:
        connected = Application(client)
        listening = asyncio.create_task(connected.listen(), name="application")
        try:
            yield connected
        finally:
            listening.cancel()
