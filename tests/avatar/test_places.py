"""One viewer with many connections, an operator that comes after it, and viewers of this machine without tokens."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_streaming.network.session_limits import ANSWER_TIME, KEPT_FOR_OPERATORS, SESSIONS_LIMIT
from websockets.asyncio.client import ClientConnection

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.session.session import EngineHost
from openrois.transport.credentials import Credentials
from tests.support import deployment
from tests.support.guarded import Guarded, ask, fresh, guarded
from tests.support.streaming import VirtualClock
from tests.support.streams import Camera
from tests.support.viewing import FedPublisher, WirelessConnection

CAMERA = "avatar/camera"


class Avatar:
    """The streams of an avatar that shows nothing, on a clock that stands still."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.streams = StreamingInterface("avatar", {CAMERA: Published(FedPublisher(), "video")}, self.clock)


@asynccontextmanager
async def avatar(gateway: Gateway, token: str = "") -> AsyncIterator[Avatar]:
    """Attach an avatar over a connection of its own."""
    made, engine = Avatar(), Engine("avatar")
    async with made.streams.sessions, TaskScope() as tasks:
        await engine.attach(LocalRegistry("avatar", [Camera()], extension=made.streams))
        credentials = Credentials(token if token else None)
        url = f"{gateway.url.replace('http', 'ws', 1)}adapter"
        tasks.start(serve_parent(EngineHost(engine, tasks), url, credentials=credentials))
        await deployment.until(gateway.engine, lambda ids: "avatar" in ids)
        yield made


@pytest.fixture(autouse=True)
def _without_network(monkeypatch: pytest.MonkeyPatch) -> None:
    WirelessConnection.stand_in(monkeypatch)


async def code(connection: ClientConnection) -> str:
    """Connect a stream, answer no offer, and return how it went."""
    answer: dict[str, Any] = await ask(connection, "rois.stream.connect_stream", component_ref=CAMERA)
    return str(answer["result"]["return_code"])


async def crowd(stack: AsyncExitStack, coming: Guarded, subject: str, count: int) -> list[str]:
    """Let connections of one viewer's token ask for a stream each, and return how it went."""
    token = fresh(sub=subject, roles=["viewer"])
    viewers = [await stack.enter_async_context(coming.dial(token)) for _ in range(count)]
    return [await code(viewer) for viewer in viewers]


async def test_a_viewer_with_64_connections_leaves_streams_to_an_operator_and_to_other_viewers(tmp_path: Path) -> None:
    robot = fresh(sub="robot", roles=["adapter"])
    async with (
        guarded(tmp_path) as coming,
        avatar(coming.gateway, robot) as shown,
        AsyncExitStack() as stack,
    ):
        codes = await crowd(stack, coming, "greedy", SESSIONS_LIMIT)
        assert (codes.count("OK"), set(codes)) == (32, {"OK", "OUT_OF_RESOURCES"})
        assert shown.streams.sessions.unanswered == 32
        assert await crowd(stack, coming, "another viewer", 1) == ["OK"]
        operator = await stack.enter_async_context(coming.dial(fresh(sub="operator", roles=["operator"])))
        assert await code(operator) == "OK"


async def test_the_avatar_keeps_places_whatever_the_quotas_of_its_gateway(tmp_path: Path) -> None:
    robot = fresh(sub="robot", roles=["adapter"])
    async with (
        guarded(tmp_path, subject_streams=1000) as coming,
        avatar(coming.gateway, robot) as shown,
        AsyncExitStack() as stack,
    ):
        codes = await crowd(stack, coming, "greedy", SESSIONS_LIMIT)
        assert codes.count("OK") == SESSIONS_LIMIT - KEPT_FOR_OPERATORS
        assert await crowd(stack, coming, "another viewer", 1) == ["OUT_OF_RESOURCES"]
        operator = await stack.enter_async_context(coming.dial(fresh(sub="operator", roles=["operator"])))
        assert await code(operator) == "OK"
        # What was not answered in time holds no place that another viewer wants.
        await shown.clock.advance(ANSWER_TIME)
        assert await crowd(stack, coming, "another viewer", 1) == ["OK"]
        assert shown.streams.sessions.displaced == 1


async def test_without_tokens_64_viewers_of_this_machine_have_a_stream_each() -> None:
    async with deployment.gateway() as gateway, avatar(gateway) as shown, AsyncExitStack() as stack:
        viewers = [await stack.enter_async_context(deployment.application(gateway)) for _ in range(SESSIONS_LIMIT + 1)]
        codes = await asyncio.gather(
            *(viewer.code("rois.stream.connect_stream", component_ref=CAMERA) for viewer in viewers)
        )
        assert codes == ["OK"] * SESSIONS_LIMIT + ["OUT_OF_RESOURCES"]
        assert len(shown.streams.sessions) == SESSIONS_LIMIT
