"""How streams end when an application or an engine leaves, and how everything passes over two hops."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest
from openrois_signaling.relay import PEERS_PER_OWNER

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.remote.serve import STREAM_GRACE
from openrois.session.session import EngineHost
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot
from tests.support.streams import SharedCamera
from tests.support.viewer import CAMERA, STATUS, peer_of, statuses, stream_of
from tests.support.wire import adapter_leg, hosted
from tests.support.wire import application as memory_application


class TestEnds:
    @pytest.mark.parametrize("form", ["method", "command"])
    async def test_a_stream_that_is_made_for_a_departed_application_is_ended(
        self, gateway: Gateway, adapter: Adapter, robot: Robot, form: str
    ) -> None:
        robot.streams.may_answer.clear()
        async with deployment.application(gateway) as leaving:
            if form == "method":
                await leaving.begin("rois.stream.connect_stream", component_ref=CAMERA)
            else:
                unit = {"component_ref": CAMERA, "command_type": "connect_stream", "command_id": "c"}
                await leaving.ask("rois.command.execute", command_unit_list=[unit, {**unit, "command_id": "d"}])
            async with deployment.patience():
                await robot.streams.called.wait()
        async with deployment.patience():
            await robot.streams.gone.wait()
        robot.streams.may_answer.set()
        async with deployment.application(gateway) as app, deployment.patience():
            while not robot.streams.forgotten[1:] or robot.streams.streams:
                await app.settled()
        assert len([call for call in robot.streams.calls if call[0] == "rois.stream.connect_stream"]) == 1

    async def test_a_stream_that_came_too_late_is_ended(self, robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
        sessions = deployment.adapter_sessions(monkeypatch)
        async with (
            deployment.gateway() as gateway,
            deployment.adapter(gateway, robot.camera, extension=robot.streams),
            deployment.application(gateway) as app,
        ):
            sessions[0].call_timeout = 0
            robot.streams.may_answer.clear()
            assert await app.code("rois.stream.connect_stream", component_ref=CAMERA) == "TIMEOUT"
            robot.streams.may_answer.set()
            async with deployment.patience():
                while len(robot.streams.calls) < 2 or robot.streams.streams:
                    await app.settled()

    async def test_a_lost_adapter(self, app: Application, other: Application, adapter: Adapter, robot: Robot) -> None:
        stream_id = await stream_of(app)
        peer_id = await peer_of(app)
        assert await statuses(app, 1) == ["NOT_RUNNING"]
        subscribed = await app.ask("rois.event.subscribe", event_type="notify_stream_status")
        await adapter.stop()
        notice = await app.next(STATUS)
        assert (notice["stream_id"], notice["component_ref"]) == (stream_id, CAMERA)
        assert notice["status"] == "STREAMING_NOT_CONNECTED"
        assert notice["timestamp"].endswith("+00:00")
        event = await app.next("rois.event.notify_event")
        assert event["subscribe_id"] == subscribed["subscribe_id"]
        assert event["results"][1]["value"] == "STREAMING_NOT_CONNECTED"
        assert await app.next("rois.system.profile_changed") == {}
        assert await app.code("rois.stream.query_stream_status", stream_id=stream_id) == "UNSUPPORTED"
        assert await app.code("signaling.restart", peer_id=peer_id) == "UNSUPPORTED"
        assert await app.settled() == []
        assert await other.settled() == ["rois.system.profile_changed"]
        await adapter.start()
        assert await stream_of(app) != stream_id
        assert await statuses(app, 1) == ["NOT_RUNNING"]
        assert await app.settled() == ["rois.system.profile_changed", "signaling.offer"]

    async def test_an_adapter_that_comes_and_goes_for_ever(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        robot = Robot()
        attached = await stack.enter_async_context(deployment.adapter(gateway, robot.camera, extension=robot.streams))
        app = await stack.enter_async_context(deployment.application(gateway))
        for _ in range(PEERS_PER_OWNER + 2):
            await stream_of(app)
            await peer_of(app)
            await attached.stop()
            await attached.start()

    async def test_when_only_the_link_is_cut_streams_go_on_for_the_grace(
        self, gateway: Gateway, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        slept: list[float] = []
        may_end = asyncio.Event()

        async def sleep(seconds: float) -> None:
            slept.append(seconds)
            await may_end.wait()

        async with deployment.adapter(gateway, robot.camera, extension=robot.streams) as adapter:
            adapter.host.sleep = sleep
            async with deployment.application(gateway) as app:
                await stream_of(app)
                await adapter.stop()
                await app.next("rois.system.profile_changed")
                assert slept == [STREAM_GRACE]
                assert len(robot.streams.streams) == 1
                may_end.set()
                async with deployment.patience():
                    while robot.streams.streams:
                        await app.settled()


class TestTwoHops:
    """A gateway behind the gateway: the application's client_id passes through, and so do ids and order."""

    @pytest.fixture
    async def middle(self) -> Engine:
        return Engine("fleet")

    @pytest.fixture
    async def leg(self, middle: Engine, robot: Robot) -> AsyncIterator[AsyncExitStack]:
        """Robot below fleet; leaving the inner stack takes the robot away."""
        async with AsyncExitStack() as outer:
            host = await outer.enter_async_context(hosted(middle))
            below = Engine("robot")
            await below.attach(LocalRegistry("robot", robot.parts(), extension=robot.streams))
            inner = await outer.enter_async_context(AsyncExitStack())
            await inner.enter_async_context(adapter_leg(host, below))
            yield inner

    async def test_one_client_id_and_the_right_order(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            hello = await app.ask("openrois.hello", version="1", extensions=[])
            for _ in range(3):
                answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
                assert answer["stream_id"].startswith("robot/")
                assert app.told.empty() or app.told.qsize() <= 2
                assert (await app.next(STATUS))["stream_id"] == answer["stream_id"]
                offer = await app.next("signaling.offer")
                assert await app.ask("signaling.restart", peer_id=offer["peer_id"]) == {"return_code": "OK"}
            report = {"stream_id": answer["stream_id"], "milliseconds": 180}
            assert await app.ask("rois.stream.report_playout", **report) == {"return_code": "OK"}
            assert robot.streams.calls[-1][:2] == ("rois.stream.report_playout", report)
            assert {client_id for _, _, client_id in robot.streams.calls} == {hello["client_id"]}

    async def test_the_application_leaves(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle):
            async with memory_application(host) as app:
                await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
            async with deployment.patience():
                await robot.streams.gone.wait()
            assert robot.streams.streams == {}

    async def test_what_is_connected_anew_outlives_what_was_before_a_cut(
        self, middle: Engine, leg: AsyncExitStack, robot: Robot
    ) -> None:
        """The link between gateway and fleet is cut and comes back within the grace."""
        grace_ends = asyncio.Event()

        async def sleep(_seconds: float) -> None:
            await grace_ends.wait()

        async with (
            TaskScope() as tasks,
            hosted(Engine("gateway")) as host,
            memory_application(host) as app,
        ):
            fleet = EngineHost(middle, tasks, sleep=sleep)
            async with adapter_leg(host, fleet):
                before = (await app.ask("rois.stream.connect_stream", component_ref=CAMERA))["stream_id"]
            async with adapter_leg(host, fleet):
                after = (await app.ask("rois.stream.connect_stream", component_ref=CAMERA))["stream_id"]
                assert set(robot.streams.streams) == {before, after}
                grace_ends.set()
                async with deployment.patience():
                    while before in robot.streams.streams:
                        await app.ask("rois.stream.query_stream_status", stream_id=after)
                answer = await app.ask("rois.stream.query_stream_status", stream_id=after)
                assert answer["return_code"] == "OK"

    async def test_connect_disconnect_connect_in_one_breath(
        self, middle: Engine, leg: AsyncExitStack, robot: Robot
    ) -> None:
        robot.streams.may_answer.clear()
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            connect = "rois.stream.connect_stream"
            first = asyncio.ensure_future(app.ask(connect, component_ref=CAMERA))
            leaving = asyncio.ensure_future(app.ask("rois.system.disconnect"))
            second = asyncio.ensure_future(app.ask(connect, component_ref=CAMERA))
            assert (await leaving)["return_code"] == "OK"
            async with deployment.patience():
                while len(robot.streams.calls) < 2:
                    await app.ask("rois.system.connect")
            robot.streams.may_answer.set()
            assert (await first)["return_code"] == "ERROR"
            stream_id = (await second)["stream_id"]
            async with deployment.patience():
                while set(robot.streams.streams) != {stream_id}:
                    await app.ask("rois.system.connect")
            answer = await app.ask("rois.stream.query_stream_status", stream_id=stream_id)
            assert answer["return_code"] == "OK"

    async def test_beside_an_engine_with_streams_one_without_is_asked_in_strict_form(
        self, middle: Engine, leg: AsyncExitStack
    ) -> None:
        shared = SharedCamera()
        plain = Engine("plain")
        await plain.attach(LocalRegistry("plain", [shared]))
        await middle.attach(plain)
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            assert (await app.ask("openrois.hello", version="1"))["engines"] == ["robot"]
            unit = {"component_ref": "plain/camera", "command_type": "connect_stream", "command_id": "c"}
            assert await app.ask("rois.command.execute", command_unit_list=[unit]) == {"return_code": "OK"}
            assert (await app.next("rois.command.completed"))["status"] == "OK"
            answer = await app.ask("rois.command.get_command_result", command_id="c")
            assert [result["value"] for result in answer["results"]] == ["the stream"]
            answer = await app.ask("rois.stream.connect_stream", component_ref="plain/camera")
            assert answer["return_code"] == "UNSUPPORTED"
            answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
            assert answer["return_code"] == "OK"

    async def test_the_adapter_is_lost(self, middle: Engine, leg: AsyncExitStack, robot: Robot) -> None:
        async with hosted(Engine("gateway")) as host, adapter_leg(host, middle), memory_application(host) as app:
            answer = await app.ask("rois.stream.connect_stream", component_ref=CAMERA)
            await app.next(STATUS)
            await leg.aclose()
            notice = await app.next(STATUS)
            assert (notice["stream_id"], notice["status"]) == (answer["stream_id"], "STREAMING_NOT_CONNECTED")
            await deployment.until(host.engine, lambda ids: "robot" not in ids)
            query = await app.ask("rois.stream.query_stream_status", stream_id=answer["stream_id"])
            assert query["return_code"] == "UNSUPPORTED"
