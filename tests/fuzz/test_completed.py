"""Each accepted command is completed exactly once, after its reply, whatever the adapter does and whenever it goes."""

import asyncio
import json
from collections import Counter
from collections.abc import Callable
from contextlib import AsyncExitStack, suppress
from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.engine.engine import Engine
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.transport.stream import StreamClosed
from tests.support.deployment import PATIENCE, until
from tests.support.plain import TOY, profile_result
from tests.support.session import settle
from tests.support.wire import adapter_leg, hosted

HELLO = {"return_code": "OK", "version": "1", "extensions": ["rois.stream"], "engines": [], "client_id": ""}
STATUSES = ["OK", "ERROR", "ABORT", "OUT_OF_RESOURCES", "TIMEOUT", "NONSENSE"]
CODES = ["OK", "OK", "OK", "ERROR", "UNSUPPORTED", "NONSENSE"]

commands = st.sampled_from(["start", "start", "say", "connect_stream", "set_parameter"])
steps = st.one_of(
    st.tuples(st.just("execute"), st.lists(st.lists(commands, min_size=1, max_size=3), min_size=1, max_size=3)),
    st.tuples(st.just("set_parameter"), st.none()),
    st.tuples(st.just("answer"), st.tuples(st.integers(0, 5), st.sampled_from(CODES))),
    st.tuples(st.just("answer"), st.tuples(st.integers(0, 5), st.sampled_from(CODES))),
    st.tuples(st.just("complete"), st.tuples(st.integers(0, 5), st.sampled_from(STATUSES))),
    st.tuples(st.just("complete"), st.tuples(st.integers(0, 5), st.sampled_from(STATUSES))),
    st.tuples(st.just("status"), st.sampled_from(["STREAMING_RUNNING", "NONSENSE"])),
    st.tuples(st.sampled_from(["restart", "disconnect"]), st.none()),
)


@dataclass
class Adapter:
    """Does nothing by itself: what it is asked is kept, and answered when a step says so."""

    host: EngineHost
    asked: list[dict[str, Any]] = field(default_factory=list)
    started: list[str] = field(default_factory=list)
    clients: list[str] = field(default_factory=list)
    minted: int = 0

    async def connect(self) -> None:
        near, self._stream = memory_pair(capacity=1000)
        self.asked.clear()
        self._serving = asyncio.ensure_future(serve_adapter(self.host, near))
        self._reading = asyncio.ensure_future(self._read(self._stream))
        await until(self.host.engine, lambda ids: "plain" in ids)

    async def _read(self, stream: MemoryStream) -> None:
        with suppress(StreamClosed):
            while True:
                request = json.loads(await stream.receive())
                params = request.get("params", {})
                self.clients += [params["client_id"]] if "client_id" in params else []
                match request.get("method"):
                    case "rois.system.get_profile":
                        await self._answer(request, profile_result("toy"))
                    case "openrois.hello":
                        await self._answer(request, HELLO)
                    case "rois.command.get_parameter":
                        await self._answer(request, {"return_code": "OK", "parameters": []})
                    case _ if "id" in request:
                        self.started += [unit["command_id"] for unit in params.get("command_unit_list", ())]
                        self.asked.append(request)

    async def _answer(self, request: dict[str, Any], result: dict[str, Any]) -> None:
        await self._send({"id": request["id"], "result": result})

    async def _send(self, message: dict[str, Any]) -> None:
        with suppress(StreamClosed):
            await self._stream.send(json.dumps({"jsonrpc": "2.0", **message}))

    async def answer(self, chosen: tuple[int, str]) -> None:
        """Answer any of the questions; it may have been answered before."""
        if not self.asked:
            return
        request = self.asked[chosen[0] % len(self.asked)]
        result = {"return_code": chosen[1]}
        self.minted += 1
        if request["method"] == "rois.command.set_parameter":
            result["command_id"] = f"plain/{self.minted // 2}"
            self.started.append(result["command_id"])
        if request["method"] == "rois.stream.connect_stream":
            result["stream_id"] = f"plain/{self.minted // 2}"
        await self._answer(request, result)

    async def complete(self, chosen: tuple[int, str]) -> None:
        """Say of any command that it has ended; it may have been said before."""
        if self.started:
            params = {"command_id": self.started[chosen[0] % len(self.started)], "status": chosen[1]}
            await self._send({"method": "rois.command.completed", "params": params})

    async def status(self, status: str) -> None:
        """Tell of a stream."""
        params = {"component_ref": TOY, "stream_id": "plain/0", "status": status, "timestamp": "now"}
        for client_id in self.clients[-1:]:
            told = {"method": "rois.stream.notify_stream_status", "params": {**params, "client_id": client_id}}
            await self._send(told)

    async def close(self) -> None:
        self._stream.abort()
        await asyncio.wait({self._serving, self._reading}, timeout=PATIENCE)

    async def restart(self, _nothing: None) -> None:
        await self.close()
        await self.connect()


@dataclass
class Application:
    """Knows of each command when it was accepted and when it ended, counted in messages."""

    stream: MemoryStream
    heard: int = 0
    questions: int = 0
    asked: dict[int, list[str]] = field(default_factory=dict)
    accepted: dict[str, int] = field(default_factory=dict)
    completed: list[tuple[str, int]] = field(default_factory=list)
    told: asyncio.Event = field(default_factory=asyncio.Event)

    async def read(self) -> None:
        with suppress(StreamClosed):
            while True:
                message = json.loads(await self.stream.receive())
                self.heard += 1
                self.told.set()
                if message.get("method") == "rois.command.completed":
                    self.completed.append((message["params"]["command_id"], self.heard))
                elif (ids := self.asked.pop(message.get("id", 0), None)) is not None:
                    result = message["result"]
                    if result["return_code"] == "OK":
                        made = result.get("command_id")
                        self.accepted |= dict.fromkeys([made] if made else ids, self.heard)

    async def _ask(self, method: str, ids: list[str], **params: Any) -> None:
        self.questions += 1
        self.asked[self.questions] = ids
        request = {"jsonrpc": "2.0", "id": self.questions, "method": method, "params": params}
        await self.stream.send(json.dumps(request))

    async def execute(self, items: list[list[str]], fresh: Callable[[], str]) -> None:
        lists = [
            [{"component_ref": TOY, "command_type": command, "command_id": fresh()} for command in item]
            for item in items
        ]
        units = [units[0] if len(units) == 1 else {"command_list": units} for units in lists]
        ids = [unit["command_id"] for units in lists for unit in units]
        await self._ask("rois.command.execute", ids, command_unit_list=units)

    async def set_parameter(self, _nothing: None) -> None:
        await self._ask("rois.command.set_parameter", [], component_ref=TOY, parameters=[])

    async def disconnect(self, _nothing: None) -> None:
        await self._ask("rois.system.disconnect", [])


async def play(steps: list[tuple[str, Any]], hops: int) -> None:
    numbers = iter(range(1000))
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(hosted(Engine("gateway")))
        below = gateway
        if hops == 2:
            below = await stack.enter_async_context(hosted(Engine("middle")))
            await stack.enter_async_context(adapter_leg(gateway, below))
        adapter = Adapter(below)
        await adapter.connect()
        await until(gateway.engine, lambda ids: "plain" in ids)
        near, far = memory_pair(capacity=1000)
        serving = asyncio.ensure_future(serve_application(gateway, near))
        app = Application(far)
        reading = asyncio.ensure_future(app.read())
        for name, chosen in steps:
            if name == "execute":
                await app.execute(chosen, lambda: f"c{next(numbers)}")
            else:
                await getattr(app if hasattr(app, name) else adapter, name)(chosen)
            await settle()
        await adapter.close()
        async with asyncio.timeout(PATIENCE):
            while app.asked or len(app.completed) < len(app.accepted):
                app.told.clear()
                await app.told.wait()
        await settle()
        assert Counter(command_id for command_id, _ in app.completed) == Counter(app.accepted.keys())
        assert all(app.accepted[command_id] < at for command_id, at in app.completed)
        assert [(host.commands.taken, host.commands.text) for host in (gateway, below)] == [(0, 0)] * 2
        far.abort()
        await asyncio.wait({serving, reading}, timeout=PATIENCE)


@pytest.mark.parametrize("hops", [1, 2])
@settings(max_examples=60, deadline=None)
@given(steps=st.lists(steps, max_size=14))
def test_exactly_one_completed(steps: list[tuple[str, Any]], hops: int) -> None:
    asyncio.run(play(steps, hops))
