"""F45: media goes from body to viewer, past the gateways: it goes on where the one that owns the body is killed."""

import asyncio
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from openrois_media import Media, VideoSource, serve
from openrois_media.client.readers import Frame, StreamReader
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import ColourBars

from openrois.client import Client, ConnectionState, Feed, Notification, Reconnect
from openrois.types.codes import StreamStatus
from openrois.types.streams import StreamStatusNotification
from tests.support.gateway_processes import PATIENCE, GatewayProcess, gateway_processes, until
from tests.support.loopback import some_address
from tests.support.nats import NatsServer
from tests.support.postgres import Server

pytestmark = [pytest.mark.media, pytest.mark.long, pytest.mark.timeout(300)]

CAMERA = "body/camera"
SIZE = (320, 180)


async def seen_at(client: Client) -> None:
    """Wait until an application sees the camera."""

    async def is_so() -> bool:
        return CAMERA in await client.search()

    await until(is_so, "the application does not see the camera")


async def disconnected(client: Client) -> None:
    """Wait until an application has noticed that its connection is lost."""

    async def is_so() -> bool:
        return client.state is not ConnectionState.CONNECTED

    await until(is_so, "the application does not notice that its gateway is gone")


async def captured_after(frames: StreamReader[Frame], moment: float, count: int = 15) -> None:
    """Wait for so many pictures that were captured after a moment."""
    async with asyncio.timeout(PATIENCE):
        while count:
            count -= (await anext(frames)).local_time > moment


async def told_of(notifications: Feed[Notification], status: StreamStatus) -> str:
    """Wait until an application is told that a stream has a status; return the stream's id."""
    async with asyncio.timeout(PATIENCE):
        async for told in notifications:
            if told.params["status"] == status.value:
                return str(told.params["stream_id"])
    raise AssertionError("the application has ended")


@pytest.mark.parametrize("front", ["a", "b"])
async def test_f45_the_picture_goes_on_without_the_gateway_of_its_body(
    front: str, shared_nats: NatsServer, postgres_server: Server, tmp_path: Path
) -> None:
    clock = SystemClock()
    bars = VideoSource(ColourBars(*SIZE, clock=clock), size=SIZE)
    with some_address():
        async with (
            gateway_processes(shared_nats, postgres_server, tmp_path, "ab") as gateways,
            # It knows no other gateway: until its own is back, nothing can take the place of its streams.
            serve(engine_id="body", streams={"camera": bars}, gateway=gateways["a"].url),
            AsyncExitStack() as stack,
        ):
            owner: GatewayProcess = gateways["a"]
            client = await stack.enter_async_context(
                Client(gateways[front].url, reconnect=Reconnect(first=0.1, limit=0.5))
            )
            await seen_at(client)
            media = await stack.enter_async_context(Media(client, clock=clock))
            told = client.notifications(StreamStatusNotification.method)
            frames = await stack.enter_async_context(media.frames(CAMERA, timeout=PATIENCE))
            former = await told_of(told, StreamStatus.STREAMING_RUNNING)
            await captured_after(frames, clock.now())

            await owner.kill()
            killed = clock.now()
            if front == "a":
                # Its session is lost with the gateway, and nothing is known of the stream.
                await disconnected(client)
            else:
                # The session goes on, and is told what became of the stream.
                assert await told_of(told, StreamStatus.STREAMING_NOT_CONNECTED) == former
            await captured_after(frames, killed)

            await owner.start()
            await owner.ready()
            latter = await told_of(told, StreamStatus.STREAMING_RUNNING)
            assert latter != former
            await captured_after(frames, clock.now())
            assert frames.status is StreamStatus.STREAMING_RUNNING
