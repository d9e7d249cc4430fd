"""A body with a camera and a microphone behind a real gateway, whose sources, sessions and connections a test holds."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from typing import Any, Final

from openrois_media import Media
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_streaming.clock import SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.client import Client, Reconnect
from openrois.component.component import Component
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing import FaultRelay
from openrois.transport.credentials import Credentials
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from tests.support.loopback import PATIENCE, Interruptible, some_address

ENGINE: Final = "robot"
CAMERA: Final = reference(ENGINE, VideoStreaming.component_type.name)
MICROPHONE: Final = reference(ENGINE, AudioStreaming.component_type.name)


class Body:
    """What runs.

    Attributes:
        url: where applications connect, over a relay that can be cut.
        relay: it.
        picture: what the camera sees, which can be held, and fail.
        video: publishes the camera.
        audio: publishes the microphone.
        screen: what applications send of their cameras.
        speaker: what they send of their microphones.
        streams: the Streaming Interface of the adapter that is there now.
    """

    def __init__(
        self,
        gateway: Gateway,
        relay: FaultRelay,
        network: NetworkSettings | None = None,
        token: str | None = None,
        others: Sequence[Component] = (),
    ) -> None:
        self.url = relay.url
        self.relay = relay
        self._network = network
        self._token = token
        self._others = others
        clock = SystemClock()
        self.picture = Interruptible(ColourBars(320, 180, clock=clock))
        self.video = VideoPublisher(self.picture, clock=clock, stamp=True, name="bars")
        self.audio = AudioPublisher(Tone(clock=clock), clock=clock, name="tone")
        self.screen = SharedInlet[RawVideo]("screen")
        self.speaker = SharedInlet[RawAudio]("speaker")
        self.streams: StreamingInterface
        self._gateway_url = gateway.url.replace("http", "ws", 1)
        self._changed = asyncio.Event()
        self._adapter = AsyncExitStack()
        gateway.engine.on_change(self._changed.set)

    async def start(self) -> None:
        """Start an adapter, and wait until the gateway has it."""
        published = {
            CAMERA: Published(self.video, "video", self.screen),
            MICROPHONE: Published(self.audio, "audio", self.speaker),
        }
        self.streams = StreamingInterface(ENGINE, published, SystemClock(), self._network)
        camera = VideoStreaming(("video/H264", "video/VP8"), published[CAMERA].directions, _ready)
        microphone = AudioStreaming(("audio/opus",), published[MICROPHONE].directions, _ready)
        await self._adapter.enter_async_context(self.streams.sessions)
        components = (camera, microphone, *self._others)
        host = await self._adapter.enter_async_context(hosted(ENGINE, *components, extension=self.streams))
        self._changed.clear()
        serving = asyncio.create_task(
            serve_parent(host, f"{self._gateway_url}adapter", credentials=Credentials(self._token))
        )
        self._adapter.push_async_callback(_cancelled, serving)
        async with asyncio.timeout(PATIENCE):
            await self._changed.wait()

    async def kill(self) -> None:
        """End the adapter, with all its peer connections, and wait until the gateway has noticed."""
        self._changed.clear()
        await self._adapter.aclose()
        async with asyncio.timeout(PATIENCE):
            await self._changed.wait()

    async def close(self) -> None:
        await self._adapter.aclose()

    @property
    def sessions(self) -> list[StreamSession]:
        """The sessions of applications with streams."""
        return [each for each in self.streams.sessions if not each.is_over]

    @property
    def session(self) -> StreamSession:
        """The session of the one application with streams."""
        (session,) = self.sessions
        return session


def _ready() -> ComponentStatus:
    return ComponentStatus.READY


async def _cancelled(task: asyncio.Task[None]) -> None:
    task.cancel()
    with suppress(asyncio.CancelledError):
        await task


@asynccontextmanager
async def body(
    settings: GatewaySettings | None = None,
    network: NetworkSettings | None = None,
    token: str | None = None,
    others: Sequence[Component] = (),
) -> AsyncIterator[Body]:
    """Run gateway and adapter in this process; nothing of them is left in the end.

    Args:
        settings: of the gateway.
        network: how the body's streams use the network.
        token: of the adapter.
        others: components of the body beside those of its streams.
    """
    with some_address():
        async with run_gateway(settings or GatewaySettings(port=0)) as gateway:
            async with FaultRelay(gateway.url.replace("http", "ws", 1)) as relay:
                one = Body(gateway, relay, network, token, others)
                await one.start()
                try:
                    yield one
                finally:
                    await one.close()
            assert one.video.running_encoders == one.audio.running_encoders == 0


@asynccontextmanager
async def application(one: Body, token: str | None = None) -> AsyncIterator[tuple[Client, Media]]:
    """An application of the body, which comes back at once when it is cut off."""
    at_once = Reconnect(first=0.01, limit=0.05)
    async with Client(one.url, token=token, reconnect=at_once) as client, Media(client) as media:
        yield client, media


async def read(reader: Any, count: int = 1) -> list[Any]:
    """Return the next items of a reader."""
    async with asyncio.timeout(PATIENCE):
        return [await anext(reader) for _ in range(count)]
