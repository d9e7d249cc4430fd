"""The messages of a sub-engine to its parent, one by one."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import urlsplit

import pytest

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.leases.epoch_fence import EpochFence
from openrois.remote.serve import STREAM_GRACE, serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.types.codes import StreamStatus
from tests.support.components import Bell, Lamp
from tests.support.deployment import gateway
from tests.support.streams import Camera, FakeStreams

CAMERA = "robot/camera"
LAMP = "robot/lamp"


class Parent:
    """The other end, by hand."""

    def __init__(self, stream: MemoryStream) -> None:
        self.stream = stream
        self.last_id = 0

    async def send(self, method: str, **params: Any) -> int:
        self.last_id += 1
        request = {"jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params}
        await self.stream.send(json.dumps(request))
        return self.last_id

    async def hear(self) -> dict[str, Any]:
        async with asyncio.timeout(60):
            message: dict[str, Any] = json.loads(await self.stream.receive())
        return message

    async def ask(self, method: str, **params: Any) -> Any:
        await self.send(method, **params)
        return (await self.hear())["result"]

    async def tell(self, method: str, **params: Any) -> None:
        await self.stream.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": params}))


class Child:
    """The engine that is served, and the time that it spends."""

    def __init__(self) -> None:
        self.streams = FakeStreams()
        self.registry = LocalRegistry("robot", [Lamp(), Bell(), Camera()], extension=self.streams)
        self.engine = Engine("robot")
        self.epoch_fence = EpochFence()
        self.slept: list[float] = []
        self.grace_ends = asyncio.Event()

    async def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        await self.grace_ends.wait()

    @asynccontextmanager
    async def served(self) -> AsyncIterator[Parent]:
        near, far = memory_pair()
        async with TaskScope() as tasks:
            host = EngineHost(
                self.engine,
                tasks,
                sleep=self.sleep,
                wall_clock=lambda: 0.0,
                epoch_fence=self.epoch_fence,
                instance="this process",
            )
            serving = asyncio.ensure_future(serve_engine(host, near))
            yield Parent(far)
            await far.close()
            await serving
            self.grace_ends.set()


@pytest.fixture
async def child() -> Child:
    made = Child()
    await made.engine.attach(made.registry)
    return made


@pytest.fixture
async def parent(child: Child) -> AsyncIterator[Parent]:
    async with child.served() as made:
        yield made


async def settle() -> None:
    for _ in range(20):
        await asyncio.sleep(0)


class TestHello:
    async def test_an_engine_with_streams(self, parent: Parent) -> None:
        answer = await parent.ask("openrois.hello", version="1", extensions=["rois.stream"])
        assert answer == {
            "return_code": "OK",
            "version": "1",
            "extensions": [
                "rois.stream",
                "signaling",
                "openrois.lease",
                "openrois.may_bind",
                "openrois.lease.stopped",
                "openrois.visitors",
            ],
            "engines": ["robot"],
            "client_id": "",
            "instance": "this process",
            "epoch": 0,
            "stopped": [],
        }

    async def test_a_parent_that_reads_the_directory(self, child: Child, parent: Parent) -> None:
        answer = await parent.ask("openrois.hello", version="1", extensions=["openrois.directory"])
        assert (answer["extensions"], answer["engines"]) == (
            [
                "rois.stream",
                "signaling",
                "openrois.directory",
                "openrois.lease",
                "openrois.may_bind",
                "openrois.lease.stopped",
                "openrois.visitors",
            ],
            [],
        )
        (entry,) = (await parent.ask("openrois.directory.list"))["engines"]
        assert (entry["engine_id"], entry["extensions"]) == ("robot", ["rois.stream", "signaling"])
        await child.engine.attach(LocalRegistry("more", [Lamp()]))
        told = await parent.hear()
        assert (told["method"], told["params"]["changed"]) == ("openrois.directory.changed", ["more"])

    async def test_an_engine_without(self, child: Child, parent: Parent) -> None:
        child.registry.extension = None
        assert (await parent.ask("openrois.hello", version="1"))["extensions"] == [
            "openrois.lease",
            "openrois.lease.stopped",
        ]

    @pytest.mark.parametrize("extensions", [[], ["openrois.directory"]])
    async def test_it_says_the_greatest_epoch_that_any_gateway_has_reported(
        self, child: Child, extensions: list[str]
    ) -> None:
        async with child.served() as former:
            await former.tell("openrois.holder", component_ref=LAMP, holds=True, epoch=7, client_id="c")
            await former.tell("openrois.holder", component_ref="robot/unknown", holds=True, epoch=9, client_id="c")
            first = await former.ask("openrois.hello", version="1", extensions=extensions)
        async with child.served() as latter:
            second = await latter.ask("openrois.hello", version="1", extensions=extensions)
        assert first["epoch"] == second["epoch"] == 7
        assert first["instance"] == second["instance"] == "this process"

    async def test_each_engine_process_has_an_instance_of_its_own(self, child: Child) -> None:
        async with TaskScope() as tasks:
            instances = {EngineHost(child.engine, tasks).instance for _ in range(2)}
        assert [len(each) for each in instances] == [32, 32]


class TestTrust:
    async def test_the_parent_needs_no_reservation_and_may_use_any_id(self, parent: Parent) -> None:
        unit = {"component_ref": "robot/lamp", "command_type": "switch", "command_id": "robot/1"}
        assert await parent.ask("rois.command.execute", command_unit_list=[unit]) == {"return_code": "OK"}
        assert (await parent.hear())["params"] == {"command_id": "robot/1", "status": "OK"}


class TestExtensionCalls:
    async def test_reply_before_what_it_causes_and_everything_with_its_client(
        self, child: Child, parent: Parent
    ) -> None:
        for client_id in ("ann", "bob"):
            await parent.send("rois.stream.connect_stream", component_ref=CAMERA, client_id=client_id)
            reply, status, offer = await parent.hear(), await parent.hear(), await parent.hear()
            assert reply["id"] == parent.last_id
            stream_id = reply["result"]["stream_id"]
            assert (status["method"], status["params"]["stream_id"]) == (
                "rois.stream.notify_stream_status",
                stream_id,
            )
            assert offer["method"] == "signaling.offer"
            assert {status["params"]["client_id"], offer["params"]["client_id"]} == {client_id}
        assert child.streams.calls[0] == ("rois.stream.connect_stream", {"component_ref": CAMERA}, "ann")

    async def test_one_client_does_not_wait_for_another(self, child: Child, parent: Parent) -> None:
        stream_id = (await parent.ask("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann"))["stream_id"]
        await parent.hear()
        await parent.hear()
        child.streams.may_answer.clear()
        await parent.send("rois.stream.connect_stream", component_ref=CAMERA, client_id="bob")
        await settle()
        child.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert (await parent.hear())["params"]["client_id"] == "ann"

    @pytest.mark.parametrize("client_id", [None, "", 5, {}])
    async def test_without_a_client(self, parent: Parent, client_id: Any) -> None:
        await parent.send("rois.stream.connect_stream", component_ref=CAMERA, client_id=client_id)
        error = (await parent.hear())["error"]
        assert (error["code"], error["data"][0]["path"]) == (-32602, "client_id")

    async def test_a_refusal(self, parent: Parent) -> None:
        answer = await parent.ask("rois.stream.suspend_stream", stream_id="robot/1", client_id="ann")
        assert answer == {"return_code": "UNSUPPORTED"}

    async def test_a_bug_is_answered_and_holds_nothing_back(
        self, child: Child, parent: Parent, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        stream_id = (await parent.ask("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann"))["stream_id"]
        await parent.hear()
        await parent.hear()
        monkeypatch.setattr(child.streams, "_own", lambda *_asked: 1 / 0)
        await parent.send("rois.stream.suspend_stream", stream_id=stream_id, client_id="ann")
        assert (await parent.hear())["error"]["code"] == -32603
        assert (await parent.hear())["params"]["error_type"] == "ENGINE_INTERNAL_ERROR"
        child.streams.announce(stream_id, StreamStatus.STREAMING_RUNNING)
        assert (await parent.hear())["params"]["status"] == "STREAMING_RUNNING"


class TestClientGone:
    async def test_its_streams_end(self, child: Child, parent: Parent) -> None:
        await parent.ask("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann")
        await parent.tell("openrois.client_gone", client_id="ann")
        await parent.tell("openrois.client_gone", client_id="ann")
        await parent.tell("openrois.client_gone", client_id="unknown")
        await parent.tell("openrois.client_gone")
        await settle()
        assert (child.streams.forgotten, child.streams.streams) == (["ann"], {})

    async def test_while_its_stream_is_made(self, child: Child, parent: Parent) -> None:
        child.streams.may_answer.clear()
        request_id = await parent.send("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann")
        await settle()
        await parent.tell("openrois.client_gone", client_id="ann")
        await settle()
        child.streams.may_answer.set()
        answer = await parent.hear()
        assert (answer["id"], answer["result"]["return_code"]) == (request_id, "ERROR")
        assert child.streams.streams == {}

    async def test_said_in_one_breath_with_the_question_for_a_stream(self, child: Child, parent: Parent) -> None:
        await parent.send("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann")
        await parent.tell("openrois.client_gone", client_id="ann")
        await settle()
        assert (child.streams.forgotten, child.streams.streams) == (["ann"], {})

    async def test_a_late_disconnect_brings_no_client_back(self, child: Child, parent: Parent) -> None:
        await parent.ask("rois.stream.disconnect_stream", stream_id="robot/1", client_id="ann")
        await parent.tell("openrois.client_gone", client_id="ann")
        await settle()
        assert child.streams.forgotten == []


class TestHolder:
    @staticmethod
    async def tell(parent: Parent, client_id: str, *, holds: bool, component_ref: str = CAMERA, epoch: int = 1) -> None:
        await parent.tell("openrois.holder", component_ref=component_ref, holds=holds, epoch=epoch, client_id=client_id)
        await settle()

    async def test_it_is_passed_on(self, child: Child, parent: Parent) -> None:
        await self.tell(parent, "ann", holds=True)
        await self.tell(parent, "bob", holds=False)
        await self.tell(parent, "ann", holds=False)
        await self.tell(parent, "ann", holds=False)
        held = {"component_ref": CAMERA, "holds": True, "epoch": 1}
        assert child.streams.calls == [
            ("openrois.holder", held, "ann"),
            ("openrois.holder", {**held, "holds": False}, "ann"),
            ("openrois.holder", {**held, "holds": False}, "ann"),
        ]

    async def test_what_is_malformed_or_about_nothing_is_passed_over(self, child: Child, parent: Parent) -> None:
        await self.tell(parent, "ann", holds=True, epoch=0)
        await self.tell(parent, "ann", holds=True, component_ref="robot/nothing")
        await self.tell(parent, "", holds=True)
        assert child.streams.calls == []

    async def test_when_the_connection_ends_so_does_all_that_is_held(self, child: Child, parent: Parent) -> None:
        await self.tell(parent, "ann", holds=True)
        await self.tell(parent, "bob", holds=True, component_ref=LAMP, epoch=2)
        await parent.tell("openrois.client_gone", client_id="bob")
        await settle()
        await parent.stream.close()
        await settle()
        assert [call for call in child.streams.calls if not call[1]["holds"]] == [
            ("openrois.holder", {"component_ref": CAMERA, "holds": False, "epoch": 1}, "ann")
        ]


class TestLostBelow:
    async def test_the_end_of_streams_is_announced_to_their_clients(self, child: Child, parent: Parent) -> None:
        stream_ids = []
        for client_id in ("ann", "bob", "cid", "dan"):
            answer = await parent.ask("rois.stream.connect_stream", component_ref=CAMERA, client_id=client_id)
            stream_ids.append(answer["stream_id"])
            await parent.hear()
            await parent.hear()
        await parent.ask("rois.stream.disconnect_stream", stream_id=stream_ids[1], client_id="bob")
        await parent.hear()
        child.streams.end(stream_ids[2])
        await parent.hear()
        await parent.tell("openrois.client_gone", client_id="dan")
        await settle()
        child.engine.detach(child.registry)
        heard = [await parent.hear(), await parent.hear()]
        notices = {message["method"]: message["params"] for message in heard}
        assert notices == {
            "rois.system.profile_changed": {},
            "rois.stream.notify_stream_status": {
                "stream_id": stream_ids[0],
                "component_ref": CAMERA,
                "status": "STREAMING_NOT_CONNECTED",
                "timestamp": "1970-01-01T00:00:00.000000+00:00",
                "client_id": "ann",
            },
        }
        await child.engine.attach(child.registry)
        assert (await parent.hear())["method"] == "rois.system.profile_changed"


class TestEnd:
    async def test_streams_go_on_for_the_grace(self, child: Child) -> None:
        async with child.served() as parent:
            await parent.ask("rois.stream.connect_stream", component_ref=CAMERA, client_id="ann")
            parent.stream.abort()
            await settle()
            assert (child.slept, len(child.streams.streams)) == ([STREAM_GRACE], 1)
            child.engine.detach(child.registry)
            await child.engine.attach(child.registry)
            child.grace_ends.set()
            await settle()
            assert "ann" in child.streams.forgotten
            assert child.streams.streams == {}

    async def test_subscriptions_end_at_once(self, child: Child) -> None:
        async with child.served() as parent:
            await parent.ask("rois.event.subscribe", event_type="rang")
            parent.stream.abort()
            await settle()
            assert not child.registry._subscriptions


async def test_of_two_gateways_that_believe_to_be_in_charge_the_later_one_is(child: Child) -> None:
    ends = [memory_pair(), memory_pair()]
    async with TaskScope() as tasks:
        host = EngineHost(child.engine, tasks, sleep=child.sleep)
        serving = [asyncio.ensure_future(serve_engine(host, near)) for near, _ in ends]
        old, new = (Parent(far) for _, far in ends)

        async def code(parent: Parent, command_id: str) -> str:
            unit = {"component_ref": LAMP, "command_type": "switch", "command_id": command_id}
            answer = await parent.ask("rois.command.execute", command_unit_list=[unit])
            if answer["return_code"] == "OK":
                assert (await parent.hear())["params"]["command_id"] == command_id
            return str(answer["return_code"])

        await old.tell("openrois.holder", component_ref=LAMP, holds=True, epoch=5, client_id="ann")
        assert await code(old, "1") == "OK"
        await new.tell("openrois.holder", component_ref=LAMP, holds=True, epoch=7, client_id="bob")
        assert await code(new, "2") == "OK"
        assert await code(old, "3") == "OUT_OF_RESOURCES"
        await old.tell("openrois.holder", component_ref=LAMP, holds=True, epoch=6, client_id="ann")
        assert await code(old, "4") == "OUT_OF_RESOURCES"
        await new.stream.close()
        await serving[1]
        assert await code(old, "5") == "OUT_OF_RESOURCES"
        await old.tell("openrois.holder", component_ref=LAMP, holds=True, epoch=8, client_id="ann")
        assert await code(old, "6") == "OK"
        await old.stream.close()
        await serving[0]
        child.grace_ends.set()
    told = [params["epoch"] for name, params, _ in child.streams.calls if name == "openrois.holder" and params["holds"]]
    assert told == [5, 7, 8]


async def test_what_acts_and_waits_for_its_turn_ends_with_the_connection(child: Child) -> None:
    """Behind a lost connection no application could stop it."""
    near, far = memory_pair()
    turn = asyncio.Event()
    async with TaskScope() as tasks:
        waiting = asyncio.Event()

        async def sleep(_seconds: float) -> None:
            waiting.set()
            await turn.wait()

        host = EngineHost(child.engine, tasks, sleep=sleep)
        serving = asyncio.ensure_future(serve_engine(host, near))
        parent = Parent(far)
        unit = {"component_ref": LAMP, "command_type": "switch", "command_id": "c", "delay_time": 5}
        assert await parent.ask("rois.command.execute", command_unit_list=[unit]) == {"return_code": "OK"}
        async with asyncio.timeout(60):
            await waiting.wait()
            await far.close()
            await serving
            assert host.commands.taken == 0
            turn.set()


async def test_an_adapter_without_requests_logs_a_warning(
    child: Child, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("openrois.remote.serve.UNASKED", 0.01)
    async with gateway() as running, TaskScope() as tasks:
        url = f"ws://127.0.0.1:{urlsplit(running.url).port}/robots"
        tasks.start(serve_parent(EngineHost(child.engine, tasks), url))
        async with asyncio.timeout(60):
            while "sends this adapter any request" not in caplog.text:  # noqa: ASYNC110 - a log wakes no task
                await asyncio.sleep(0.01)
    assert f"no gateway at {url} sends" in caplog.text
