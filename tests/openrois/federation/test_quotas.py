"""Quotas of one subject over all gateways of a cluster."""

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from pathlib import Path

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from openrois.transport.credentials import Credentials
from tests.support.cluster import seen_by
from tests.support.deployment import Application, Robot, application, patience
from tests.support.gateway_processes import gateway_processes, until
from tests.support.guarded import fresh
from tests.support.nats import NatsServer
from tests.support.place import Place, owned_by, place_of
from tests.support.postgres import Server
from tests.support.streams import FakeStreams
from tests.support.tokens import key_file

pytestmark = pytest.mark.extra(name="cluster")

CONNECTIONS = 2


def dial(url: str, subject: str) -> connect:
    headers = {"Authorization": f"Bearer {fresh(sub=subject)}"}
    return connect(url.replace("http", "ws", 1), additional_headers=headers, proxy=None)


async def refusal(url: str, subject: str) -> str:
    """Return why one more connection of a subject is refused; empty where it is not."""
    try:
        async with dial(url, subject):
            return ""
    except InvalidStatus as refused:
        answer = refused.response
    assert answer.status_code == 429
    return answer.body.decode()


async def refused_at(url: str, subject: str) -> str:
    """Wait until a subject is refused at a gateway; return why."""
    said = ""

    async def is_so() -> bool:
        nonlocal said
        said = await refusal(url, subject)
        return bool(said)

    await until(is_so, f"{subject} is accepted at {url}")
    return said


async def accepted_at(url: str, subject: str) -> None:
    """Wait until a subject is accepted at a gateway."""

    async def is_so() -> bool:
        return not await refusal(url, subject)

    await until(is_so, f"{subject} is refused at {url}")


@pytest.fixture
async def place(shared_nats: NatsServer, postgres_server: Server, tmp_path: Path) -> AsyncIterator[Place]:
    """Two gateways that ask for tokens."""
    quotas = {"subject_connections": CONNECTIONS, "subject_sessions": 2 * CONNECTIONS, "subject_streams": 3}
    settings = {"auth_keys": (key_file(tmp_path),), **quotas}
    async with place_of(shared_nats, postgres_server, "a", "b", **settings) as place:
        yield place


async def test_a_subject_has_so_many_connections_at_all_gateways(place: Place) -> None:
    a, b = (place.gateway(each).url for each in "ab")
    async with AsyncExitStack() as stack:
        taken: list[ClientConnection] = [await stack.enter_async_context(dial(a, "ann")) for _ in range(CONNECTIONS)]
        assert await refused_at(b, "ann") == "one subject has at most 2 connections; at other gateways there are 2\n"
        await stack.enter_async_context(dial(b, "bob"))
        await taken[0].close()
        await accepted_at(b, "ann")
        await stack.enter_async_context(dial(b, "ann"))
        await refused_at(a, "ann")
    await accepted_at(a, "ann")


async def test_a_subject_has_so_many_streams_at_all_gateways(place: Place, tmp_path: Path) -> None:
    second = Robot(streams=FakeStreams("second"))
    for gateway_id, engine_id, robot in (("a", "robot", place.robot), ("b", "second", second)):
        token = tmp_path / engine_id
        token.write_text(fresh(sub=engine_id, roles=["adapter"], scope=[f"{engine_id}/*"]))
        token.chmod(0o600)
        place.robot = robot
        await place.wander(gateway_id, engine_id=engine_id, credentials=Credentials.of_files(token, None))
        await owned_by(place, gateway_id, engine_id)
    app = await place.stack.enter_async_context(viewer(place, "b", "ann"))
    other = await place.stack.enter_async_context(viewer(place, "a", "ann"))
    for each in (app, other):
        await seen_by(each, "robot", "second")
    # Of what is asked through b, a has the streams: each of them counts there, and there alone.
    streams = []
    for ref in ("robot/camera", "robot/camera", "robot/camera"):
        answer = await app.ask("rois.stream.connect_stream", component_ref=ref)
        assert answer["return_code"] == "OK"
        streams.append(answer["stream_id"])
    full = ("OUT_OF_RESOURCES", "one subject has at most 3 streams")
    assert await app.why("rois.stream.connect_stream", component_ref="robot/camera") == full
    async with patience():
        while (more := await other.ask("rois.stream.connect_stream", component_ref="second/camera")).get("stream_id"):
            assert await other.code("rois.stream.disconnect_stream", stream_id=more["stream_id"]) == "OK"
    why = await other.why("rois.stream.connect_stream", component_ref="second/camera")
    assert why == (full[0], f"{full[1]}; at other gateways there are 3")
    assert await app.code("rois.stream.disconnect_stream", stream_id=streams[0]) == "OK"
    await other.eventually("OK", "rois.stream.connect_stream", component_ref="second/camera")


def viewer(place: Place, gateway_id: str, subject: str) -> AbstractAsyncContextManager[Application]:
    headers = {"Authorization": f"Bearer {fresh(sub=subject, roles=['operator'], scope=['*'])}"}
    return application(place.gateway(gateway_id), additional_headers=headers)


async def test_what_a_subject_had_at_a_gateway_that_is_killed_counts_no_more(
    shared_nats: NatsServer, postgres_server: Server, tmp_path: Path
) -> None:
    options = ("--auth-key", str(key_file(tmp_path)), "--subject-connections", str(CONNECTIONS))
    async with gateway_processes(shared_nats, postgres_server, tmp_path, "ab", options=options) as running:
        a, b = running["a"], running["b"]
        async with AsyncExitStack() as stack:
            for _ in range(CONNECTIONS):
                await stack.enter_async_context(dial(a.url, "ann"))
            await refused_at(b.url, "ann")
            await a.kill()
            await accepted_at(b.url, "ann")
            for _ in range(CONNECTIONS):
                await stack.enter_async_context(dial(b.url, "ann"))
            # One that comes up learns of it, too.
            await a.start()
            await a.ready()
            await refused_at(a.url, "ann")
