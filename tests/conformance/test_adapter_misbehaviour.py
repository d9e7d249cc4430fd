"""Whatever an adapter does, applications get one correct answer, and others get theirs."""

import asyncio
import json
from contextlib import AsyncExitStack
from typing import Any, ClassVar

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.session.session import EngineHost
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.deployment import Adapter, Application
from tests.support.plain import (
    TOY,
    attached,
    gateway_url,
    plain_adapter,
    profile_result,
    refusal,
)


class TestMisbehaviour:
    """Whatever an adapter does, applications get one correct answer, and others get theirs."""

    async def test_results_that_are_none(
        self, gateway: Gateway, stack: AsyncExitStack, subtests: pytest.Subtests
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        result = '{"jsonrpc":"2.0","id":"ID","result":%s}'
        for answer in (
            result % "null",
            result % "[]",
            result % '{"return_code":"FINE"}',
            result % '{"return_code":"OK","results":null}',
            result % '{"return_code":"OK","results":[{"name":"n","data_type_ref":"int","value":5}]}',
            result % '{"return_code":"OK","results":[1e999]}',
            '{"jsonrpc":"2.0","id":"ID","error":{"code":1,"message":"the secret"}}',
            '{"jsonrpc":"2.0","id":"ID","error":"the secret"}',
        ):
            with subtests.test(answer):
                plain.answers["rois.query.query"] = answer
                assert await app.ask("rois.query.query", query_type="mood") == {"return_code": "ERROR", "results": []}
        assert "secret" not in json.dumps(app.heard)
        del plain.answers["rois.query.query"]
        assert await app.code("rois.query.query", query_type="mood") == "OK"

    async def test_ids_it_may_not_mint(
        self, gateway: Gateway, stack: AsyncExitStack, subtests: pytest.Subtests
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        for minted in ("", "x", "robot/1", "gateway/1", "plain"):
            with subtests.test(minted):
                plain.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": minted}
                answer = await app.ask("rois.event.subscribe", event_type="laughed")
                assert answer == {"return_code": "ERROR", "subscribe_id": ""}
                plain.answers["rois.command.set_parameter"] = {"return_code": "OK", "command_id": minted}
                set_parameter = await app.ask("rois.command.set_parameter", component_ref=TOY, parameters=[])
                command_id = set_parameter["command_id"]
                assert await app.completed(command_id) == {command_id: "ERROR"}

    async def test_ids_it_mints_twice(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway, profile_result("toy", "game")))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        plain.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": "plain/sub"}
        codes = [
            await app.code("rois.event.subscribe", event_type="laughed", condition=f"component_ref = '{ref}'")
            for ref in (TOY, "plain/game")
        ]
        assert codes == ["OK", "ERROR"]
        plain.hold_completed = True
        plain.answers["rois.command.set_parameter"] = {"return_code": "OK", "command_id": "plain/param"}
        ids = [
            (await app.ask("rois.command.set_parameter", component_ref=TOY, parameters=[]))["command_id"]
            for _ in range(2)
        ]
        assert await app.completed(ids[1]) == {ids[1]: "ERROR"}
        await plain.tell_completed("plain/param", "ABORT")
        assert await app.completed(ids[0]) == {ids[0]: "ABORT"}

    async def test_events_it_may_not_tell(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        plain.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": "plain/sub"}
        await app.ask("rois.event.subscribe", event_type="laughed")
        await plain.tell_event("plain/other", "laughed")
        await plain.tell_event("plain/sub", "cried")
        await plain.tell_event("plain/sub", "laughed", event_id="robot/evt-1")
        await plain.tell("rois.event.notify_event", event_id=5)
        await plain.tell_event("plain/sub", "laughed", event_id="plain/evt-2")
        assert (await app.next("rois.event.notify_event"))["event_id"] == "plain/evt-2"
        assert await app.settled() == []

    async def test_requests_garbage_and_unrequested_answers_are_ignored(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        for raw in (
            "garbage",
            "[]",
            '{"jsonrpc":"2.0","id":99,"result":{}}',
            '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"x"}}',
            '{"jsonrpc":"2.0","method":"rois.system.notify_error","params":{"error_id":"e","error_type":"X"}}',
            '{"jsonrpc":"2.0","method":"signaling.offer","params":{"client_id":"x","peer_id":"plain/1"}}',
        ):
            await plain.socket.send(raw)
        assert await app.code("rois.query.query", query_type="mood") == "OK"
        assert await app.settled() == []
        assert plain.refusals == [-32700, -32600]

    async def test_one_cannot_reach_the_applications_methods(self, gateway: Gateway) -> None:
        async with connect(gateway_url(gateway)) as socket:
            asked = json.loads(await socket.recv())
            await socket.send(json.dumps({"jsonrpc": "2.0", "id": asked["id"], "result": profile_result("toy")}))
            await socket.recv()
            await socket.send('{"jsonrpc":"2.0","id":1,"method":"rois.command.search"}')
            async with deployment.patience():
                answer = json.loads(await socket.recv())
            assert answer["error"]["code"] == -32601

    async def test_twins_cannot_both_be_here(self, gateway: Gateway, adapter: Adapter, app: Application) -> None:
        waiting = asyncio.Event()

        async def sleep(_seconds: float) -> None:
            waiting.set()
            await asyncio.Event().wait()

        async with TaskScope() as tasks:
            twin = Engine("robot")
            await twin.attach(LocalRegistry("robot", [Lamp()]))
            dialling = tasks.start(serve_parent(EngineHost(twin, tasks), gateway_url(gateway), sleep=sleep))
            async with deployment.patience():
                await waiting.wait()
            dialling.cancel()
        assert await app.code("rois.command.bind", component_ref="robot/lamp") == "OK"

    async def test_the_gateway_closes_with_going_away(self) -> None:
        closed: list[Any] = []
        async with AsyncExitStack() as stack:
            async with deployment.gateway() as gateway:
                plain = await stack.enter_async_context(plain_adapter(gateway))
                await attached(gateway)
                app = await stack.enter_async_context(deployment.application(gateway))
            closed.append(await refusal(plain))
            with pytest.raises(ConnectionClosed):
                await app.hear()
            closed.append((app.socket.close_code, app.socket.close_reason))
        assert [code for code, _ in closed] == [1001, 1001]


class TestStreams:
    """Notifications of an adapter about streams are read before it waits for anything."""

    HELLO: ClassVar = {
        "return_code": "OK",
        "version": "1",
        "extensions": ["rois.stream"],
        "engines": [],
        "client_id": "",
    }

    async def test_nonsense_while_a_command_of_a_stream_runs(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway, openrois__hello=self.HELLO))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.ask("openrois.hello", version="1")
        plain.answers["rois.stream.connect_stream"] = None
        units = [
            {"component_ref": TOY, "command_type": command, "command_id": command}
            for command in ("connect_stream", "start")
        ]
        await app.ask("rois.command.execute", command_unit_list=units)
        async with deployment.patience():
            connect_stream = await plain.unanswered.get()
        told = {"client_id": connect_stream["params"]["client_id"], "stream_id": "plain/1", "component_ref": TOY}
        await plain.tell("rois.stream.notify_stream_status", **told, status="NONSENSE")
        await plain.tell("signaling.offer", **told)
        await plain.answer(connect_stream, return_code="OK", stream_id="plain/1")
        assert await app.completed("connect_stream", "start") == {"connect_stream": "OK", "start": "OK"}
        assert await app.settled() == []
