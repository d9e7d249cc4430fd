"""The suite's own adapter: it dials the gateway, answers its requests, and does what a check orders."""

import asyncio
import json
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any

from websockets.asyncio.client import ClientConnection
from websockets.exceptions import ConnectionClosed

from openrois_conformance.connection import Connection
from openrois_conformance.deviation import Deviation, shown
from openrois_conformance.door import Door
from openrois_conformance.probe_engine import Answer, ProbeEngine
from openrois_conformance.transcript import Transcript

__all__ = ["Probe", "dialled", "new_engine_id"]


def new_engine_id() -> str:
    """Return an engine id that no tree has yet."""
    return f"conformance-{secrets.token_hex(4)}"


class Probe(Connection):
    """An adapter of the suite, connected.

    Args:
        socket: the open connection.
        engine: answers what the gateway asks.
        transcript: keeps what is said.
        patience: seconds to wait for anything.

    Attributes:
        asked: what the gateway asked: method and params, in order.
        refusals: the codes of the errors that the gateway sent.
    """

    def __init__(self, socket: ClientConnection, engine: ProbeEngine, transcript: Transcript, patience: float) -> None:
        super().__init__(socket, "adapter", transcript, patience)
        self.engine = engine
        self.asked: list[tuple[str, dict[str, Any]]] = []
        self.refusals: list[int] = []
        self._held: list[Any] = []
        self._change = asyncio.Event()

    def reset(self) -> None:
        """Drop the records of earlier checks."""
        self.asked.clear()
        self.refusals.clear()
        self.engine.reset()

    def ref(self, name: str) -> str:
        """Return the component_ref of a component by its name."""
        return next(ref for ref in self.engine.profiles if ref.rpartition("/")[2] == name)

    async def run(self) -> None:
        """Answer until the connection ends."""
        with suppress(ConnectionClosed, Deviation):
            while True:
                text = str(await self.socket.recv())
                self._transcript.note(self.name, text, outgoing=False)
                await self._handle_message(json.loads(text))
                self._change.set()

    async def _handle_message(self, message: dict[str, Any]) -> None:
        if "error" in message:
            self.refusals.append(message["error"]["code"])
        if "method" not in message:
            return
        method, params = message["method"], message.get("params") or {}
        self.asked.append((method, params))
        if "id" not in message:
            return
        answer = self.engine.answer_request(method, params)
        if answer.result is None and answer.error is None:
            self._held.append(message["id"])
        else:
            await self._send_answer(message["id"], answer)

    async def _send_answer(self, request_id: Any, answer: Answer) -> None:
        envelope = {"jsonrpc": "2.0", "id": request_id}
        if answer.error is not None:
            envelope["error"] = {"code": answer.error, "message": "the suite's adapter refuses"}
        else:
            envelope["result"] = answer.result
        await self.send(envelope)
        for method, params in answer.then:
            await self.send_notification(method, **params)

    async def send_notification(self, method: str, **params: Any) -> None:
        """Send a notification."""
        await self.send({"jsonrpc": "2.0", "method": method, "params": params})

    async def until(self, condition: Callable[[], bool], what: str) -> None:
        """Wait until a condition on the gateway's requests holds."""
        try:
            async with asyncio.timeout(self.patience):
                while not condition():
                    self._change.clear()
                    await self._change.wait()
        except TimeoutError:
            raise Deviation(f"the gateway, within {self.patience:g} s, to {what}", "it does not") from None

    def params_of(self, method: str) -> list[dict[str, Any]]:
        """Return the params of every request of `method`, in order."""
        return [params for name, params in self.asked if name == method]

    def last(self, method: str) -> dict[str, Any]:
        """Return the params of the latest request of `method`."""
        found = self.params_of(method)
        if not found:
            raise Deviation(f"the gateway to ask its adapter {method}", shown([name for name, _ in self.asked]))
        return found[-1]

    async def happen(self, component_ref: str, event_type: str = "happened") -> str:
        """Announce an event to every subscription to it and return its id."""
        event_id, notices = self.engine.event(component_ref, event_type)
        for method, params in notices:
            await self.send_notification(method, **params)
        return event_id

    async def hangs(self, component_ref: str) -> None:
        """Wait until a command of a component hangs."""
        await self.until(lambda: component_ref in self.engine.hanging(), f"start a command of {component_ref}")

    async def finish(self, component_ref: str, status: str = "OK") -> None:
        """End the commands of a component that hang."""
        for method, params in self.engine.finish(component_ref, status):
            await self.send_notification(method, **params)

    async def answer_held(self, result: dict[str, Any] | None = None) -> None:
        """Answer the requests that were not answered, all with one result."""
        held, self._held = self._held, []
        for request_id in held:
            await self._send_answer(request_id, Answer(result or {"return_code": "OK", "results": []}))

    async def let_go(self) -> None:
        """End whatever hangs, so that nothing of a check outlives it."""
        with suppress(Deviation):
            for component_ref in self.engine.hanging():
                await self.finish(component_ref, "ABORT")
            await self.answer_held({"return_code": "ERROR"})


@asynccontextmanager
async def dialled(door: Door, transcript: Transcript, patience: float, engine: ProbeEngine) -> AsyncIterator[Probe]:
    """Connect an adapter of the suite for as long as the block runs.

    Args:
        door: where the gateway takes adapters.
        transcript: keeps what is said.
        patience: seconds to wait for anything.
        engine: answers what the gateway asks.

    Raises:
        ValueError: the token cannot be read.
        OSError: nothing listens there.
        websockets.exceptions.InvalidHandshake: adapters are not let in.
    """
    async with door.opened(patience) as socket:
        probe = Probe(socket, engine, transcript, patience)
        serving = asyncio.ensure_future(probe.run())
        try:
            yield probe
        finally:
            await probe.let_go()
            await socket.close()
            serving.cancel()
            await asyncio.wait({serving})
