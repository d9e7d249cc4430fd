"""An adapter that speaks the base wire and nothing else, with no code of ours behind it."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from openrois.gateway.server import Gateway
from tests.support.deployment import PATIENCE, adapter_url, patience, told_across, until

TOY = "plain/toy"


def identifier(code: str) -> dict[str, str]:
    return {"code": code, "authority": "", "codebook_ref": "", "version": ""}


def engine_profile(engine_id: str, *refs: str, below: tuple[dict[str, Any], ...] = ()) -> dict[str, Any]:
    """Return an engine's profile as upstream writes it."""
    return {
        "identifier": identifier(engine_id),
        "sub_profiles": list(below),
        "component_ids": list(refs),
        "parameter_profiles": [],
    }


def component_profile(name: str) -> dict[str, Any]:
    """Return the profile of a component with one message of each kind, the smallest that is allowed."""
    text = {"name": "text", "data_type_ref": {"code": "string"}}
    return {
        "identifier": {"code": "urn:x-rois:def:component:Test::Plain"},
        "name": name,
        "command_profiles": [
            {"name": "start"},
            {"name": "say", "arguments": [text], "results": [text]},
            {"name": "connect_stream", "results": [text]},
        ],
        "query_profiles": [{"name": "mood"}, {"name": "get_stream_status"}],
        "event_profiles": [{"name": "laughed"}, {"name": "notify_stream_status"}],
        "parameter_profiles": [text],
    }


@dataclass
class PlainAdapter:
    """The requests of the gateway, and the responses.

    Attributes:
        asked: every request: its method and params.
        answers: what a method answers, instead of the usual; None leaves it to the test.
        unanswered: the requests that were left to the test.
        profile: what `get_profile` answers.
        refusals: the codes of the errors that it was answered.
        hold_completed: whether `completed` is left to the test.
        last_id: the id of the last request.
        methods: what was asked that no test has waited for.
        known: ids of commands that it has had already; it refuses another of such an id.
    """

    socket: ClientConnection
    profile: dict[str, Any]
    answers: dict[str, Any] = field(default_factory=dict)
    asked: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    unanswered: asyncio.Queue[dict[str, Any]] = field(default_factory=asyncio.Queue)
    refusals: list[int] = field(default_factory=list)
    hold_completed: bool = False
    minted: int = 0
    last_id: int = 0
    known: set[str] = field(default_factory=set)
    methods: asyncio.Queue[str] = field(default_factory=asyncio.Queue)

    async def run(self) -> None:
        with suppress(ConnectionClosed):
            while True:
                message = json.loads(await self.socket.recv())
                if "error" in message:
                    self.refusals.append(message["error"]["code"])
                    continue
                assert set(message) <= {"jsonrpc", "id", "method", "params"}, message
                if "id" in message:
                    await self._answer(message)

    async def _answer(self, request: dict[str, Any]) -> None:
        method, params = request["method"], request["params"]
        assert type(request["id"]) is int
        self.last_id = request["id"]
        self.asked.append((method, params))
        self.methods.put_nowait(method)
        answer = self.answers.get(method, ...)
        if answer is None:
            self.unanswered.put_nowait(request)
            return
        envelope: dict[str, Any] = {"jsonrpc": "2.0", "id": request["id"]}
        if isinstance(answer, str):
            await self.socket.send(answer.replace('"ID"', str(request["id"])))
            return
        result = self._usual(method, params) if answer is ... else answer
        if method == "rois.command.execute" and params["command_unit_list"][0]["command_id"] in self.known:
            await self.answer(request, return_code="BAD_PARAMETER")
            return
        if result is None:
            envelope["error"] = {"code": -32601, "message": "Method not found"}
        else:
            envelope["result"] = result
        await self.socket.send(json.dumps(envelope))
        if method == "rois.command.execute" and not self.hold_completed:
            await self.tell_completed(params["command_unit_list"][0]["command_id"])
        if method == "rois.command.set_parameter" and not self.hold_completed:
            await self.tell_completed(f"plain/param-{self.minted}")

    def _usual(self, method: str, params: dict[str, Any]) -> dict[str, Any] | None:
        self.minted += 1
        text = {"name": "text", "data_type_ref": "string", "value": "fine"}
        usual: dict[str, dict[str, Any]] = {
            "rois.system.get_profile": self.profile,
            "rois.command.execute": {"return_code": "OK"},
            "rois.command.set_parameter": {"return_code": "OK", "command_id": f"plain/param-{self.minted}"},
            "rois.command.get_parameter": {"return_code": "OK", "parameters": [text]},
            "rois.command.get_command_result": {"return_code": "OK", "results": [text]},
            "rois.query.query": {"return_code": "OK", "results": [text]},
            "rois.event.subscribe": {"return_code": "OK", "subscribe_id": f"plain/sub-{self.minted}"},
            "rois.event.unsubscribe": {"return_code": "OK"},
        }
        return usual.get(method)

    async def answer(self, request: dict[str, Any], **result: Any) -> None:
        await self.socket.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}))

    async def tell(self, method: str, **params: Any) -> None:
        await self.socket.send(json.dumps({"jsonrpc": "2.0", "method": method, "params": params}))

    async def tell_completed(self, command_id: str, status: str = "OK") -> None:
        await self.tell("rois.command.completed", command_id=command_id, status=status)

    async def tell_event(self, subscribe_id: str, event_type: str, event_id: str = "plain/evt-1") -> None:
        await self.tell(
            "rois.event.notify_event",
            event_id=event_id,
            event_type=event_type,
            subscribe_id=subscribe_id,
            expire="2030-01-01T00:00:00+00:00",
            results=[{"name": "text", "data_type_ref": "string", "value": "ha"}],
        )

    async def heard(self, method: str) -> None:
        """Wait until `method` is asked that was not waited for before."""
        async with patience():
            while await self.methods.get() != method:
                pass

    def last(self, method: str) -> dict[str, Any]:
        """Return the params of the latest request of `method`."""
        return next(params for name, params in reversed(self.asked) if name == method)


def profile_result(*names: str, engine_id: str = "plain") -> dict[str, Any]:
    """Return a result of get_profile with components of these names."""
    refs = [f"{engine_id}/{name}" for name in names]
    return {
        "return_code": "OK",
        "profile": engine_profile(engine_id, *refs),
        "component_profiles": {ref: component_profile(ref.rpartition("/")[2]) for ref in refs},
    }


def _method(name: str) -> str:
    return name.replace("__", ".") if name.startswith("openrois__") else f"rois.{name.replace('__', '.')}"


@asynccontextmanager
async def plain_adapter(
    gateway: Gateway, profile: dict[str, Any] | None = None, path: str = "adapter", **answers: Any
) -> AsyncIterator[PlainAdapter]:
    """Connect a plain adapter; `answers` are by the method's name, with `__` for its dots."""
    async with connect(adapter_url(gateway).removesuffix("adapter") + path) as socket:
        adapter = PlainAdapter(socket, profile or profile_result("toy"))
        adapter.answers = {_method(name): answer for name, answer in answers.items()}
        running = asyncio.ensure_future(adapter.run())
        try:
            yield adapter
        finally:
            await socket.close()
            async with asyncio.timeout(PATIENCE):
                await running


async def attached(gateway: Gateway, engine_id: str = "plain") -> None:
    """Wait until an engine is part of the gateway's tree."""
    await until(gateway.engine, lambda ids: engine_id in ids)
    await told_across(gateway, lambda ids: engine_id in ids)


def gateway_url(gateway: Gateway) -> str:
    """Return where adapters connect."""
    return adapter_url(gateway)


async def refusal(adapter: PlainAdapter) -> tuple[int, str]:
    """Wait until the gateway closes the connection; return its code and reason."""
    async with patience():
        await adapter.socket.wait_closed()
    return adapter.socket.close_code or 0, adapter.socket.close_reason or ""
