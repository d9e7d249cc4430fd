"""One application's session: what it may operate, and what is left when it leaves."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted
from openrois.interfaces.stream import connect_stream
from openrois.session.session import ApplicationSession, EngineHost
from openrois.types.codes import CompletedStatus, StreamStatus
from tests.support.components import Bell, Lamp
from tests.support.streams import Camera, FakeStreams
from tests.support.wire import hosted

LAMP, CAMERA = "robot/lamp", "robot/camera"


class Told:
    """The notifications of the application, and those that are withheld."""

    def __init__(self) -> None:
        self.methods: list[str] = []
        self.kept_back: set[str] = set()

    def notify(self, method: str, _params: dict[str, Any], *, droppable: bool = False) -> None:
        assert not droppable
        self.methods.append(method)

    def passes(self, method: str, _params: Any) -> bool:
        return method not in self.kept_back


@pytest.fixture
def told() -> Told:
    return Told()


@pytest.fixture
async def streams() -> FakeStreams:
    return FakeStreams()


@pytest.fixture
async def registry(streams: FakeStreams) -> LocalRegistry:
    return LocalRegistry("robot", [Lamp(), Bell(), Camera()], extension=streams)


@pytest.fixture
async def host(registry: LocalRegistry) -> AsyncIterator[EngineHost]:
    engine = Engine("gateway")
    await engine.attach(registry)
    async with hosted(engine) as made:
        yield made


@pytest.fixture
def app(host: EngineHost, told: Told) -> ApplicationSession:
    return ApplicationSession(host, told.notify, passes=told.passes)


async def test_operating_needs_a_lease(host: EngineHost, app: ApplicationSession, told: Told) -> None:
    trusted = ApplicationSession(host, told.notify, trusted=True)
    assert (app.may_operate(LAMP), trusted.may_operate(LAMP)) == (False, True)
    host.leases.bind(LAMP, app)
    assert app.may_operate(LAMP)


async def test_how_a_command_ended_is_told(app: ApplicationSession, told: Told) -> None:
    app.completed("c", CompletedStatus.ABORT)
    assert told.methods == ["rois.command.completed"]


async def test_clients_are_told_apart(host: EngineHost, told: Told) -> None:
    ids = {ApplicationSession(host, told.notify).client_id for _ in range(10)}
    assert len(ids) == 10
    assert all(len(bytes.fromhex(client_id)) == 16 for client_id in ids)


async def test_what_may_not_pass_is_not_heard(app: ApplicationSession, told: Told, streams: FakeStreams) -> None:
    app.extended = True
    told.kept_back.add("signaling.offer")
    stream_id = await connect_stream(app, CAMERA, ())
    assert told.methods == ["rois.stream.notify_stream_status"]
    told.kept_back.add("rois.stream.notify_stream_status")
    streams.announce(stream_id, StreamStatus.STREAMING_NOT_CONNECTED)
    assert list(app.streams) == [stream_id]


async def test_a_stream_that_ended_is_forgotten(app: ApplicationSession, streams: FakeStreams) -> None:
    stream_id = await connect_stream(app, CAMERA, ())
    streams.announce(stream_id, StreamStatus.STREAMING_SUSPENDED)
    assert app.streams == {stream_id: CAMERA}
    streams.end(stream_id)
    assert app.streams == {}


async def test_leaving_gives_everything_back(host: EngineHost, registry: LocalRegistry, streams: FakeStreams) -> None:
    told, left = Told(), asyncio.Event()
    app = ApplicationSession(host, told.notify, left=left.set)
    app.extended = True
    host.leases.bind(LAMP, app)
    reply = await app.events.subscribe("robot/bell", "rang", of_streams=False)
    assert reply.then is not None
    reply.then()
    await connect_stream(app, CAMERA, ())
    replied = app.order.asked("robot")
    streams.announce(next(iter(streams.streams)), StreamStatus.STREAMING_RUNNING)
    told.methods.clear()
    await app.leave()
    replied()
    assert (app.may_operate(LAMP), app.streams, streams.streams) == (False, {}, {})
    assert (streams.forgotten, left.is_set(), told.methods) == ([app.client_id], True, [])
    await host.engine.attach(LocalRegistry("other", []))
    assert told.methods == ["rois.system.profile_changed"]
    await app.close()
    await host.engine.attach(LocalRegistry("third", []))
    assert told.methods == ["rois.system.profile_changed"]


async def test_a_stream_that_is_made_for_a_departed_application_is_ended(
    app: ApplicationSession, streams: FakeStreams
) -> None:
    streams.may_answer.clear()
    connecting = asyncio.ensure_future(connect_stream(app, CAMERA, ()))
    await asyncio.sleep(0)
    await app.leave()
    streams.may_answer.set()
    with pytest.raises(Aborted):
        await connecting
    assert (streams.streams, app.streams) == ({}, {})
    await connect_stream(app, CAMERA, ())
    await app.close()
    with pytest.raises(Aborted):
        await connect_stream(app, CAMERA, ())
    assert streams.streams == {}


async def test_streams_of_an_engine_that_is_gone_are_announced(
    app: ApplicationSession, host: EngineHost, registry: LocalRegistry, told: Told
) -> None:
    app.extended = True
    await connect_stream(app, CAMERA, ())
    told.methods.clear()
    host.engine.detach(registry)
    assert told.methods == ["rois.stream.notify_stream_status", "rois.system.profile_changed"]
    assert app.streams == {}
