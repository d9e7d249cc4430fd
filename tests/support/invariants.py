"""Invariants that hold after every fault, and applications that record all messages for them.

I1  each request gets exactly one response, and one that was cut off at most one
I2  each accepted command gets exactly one `completed`, after its acceptance
I3  a component never has two holders
I4  no event without a subscription that stands, and no status of a stream that has ended
I5  when all have left, commands, tasks, file descriptors and engines are as before
I6  what was dropped was counted, and told to those who understand that
I7  no text says what is not for applications: a traceback, a path, a secret
I8  the gateway lives, and is ready again
I9  the audit trail is whole and in order
I10 no task failed unheard, and nothing kept the loop busy for long
"""

import asyncio
import gc
import json
import time
from collections import Counter
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, TypeVar

import psutil
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed

from tests.support.schema import check_notification, check_result

__all__ = ["LONGEST_BLOCK", "PATIENCE", "Book", "Witness", "calm", "check_audit"]

W = TypeVar("W", bound="Witness")

PATIENCE: Final = 30.0
"""Seconds that anything may take on a busy machine; with time for it nearly all takes hundredths."""
LONGEST_BLOCK: Final = 0.1
"""Seconds of processor time that one turn of the loop may take."""

_NEVER_SAID: Final = ("Traceback", 'File "', ".py", "site-packages", "canary")


@dataclass
class Book:
    """Records of all witnesses of one run, in order.

    Attributes:
        witnesses: the applications.
        holders: who holds which component, as the replies say.
        accepted: how many commands were accepted.
    """

    witnesses: list["Witness"] = field(default_factory=list)
    holders: dict[str, "Witness"] = field(default_factory=dict)
    accepted: int = 0

    def witness(self, url: str, *, extended: bool = False, **options: Any) -> AbstractAsyncContextManager["Witness"]:
        """Connect one more application."""
        return self.application(Witness, url, extended=extended, **options)

    @asynccontextmanager
    async def application(
        self, make: Callable[["Book", ClientConnection], W], url: str, *, extended: bool = False, **options: Any
    ) -> AsyncIterator[W]:
        """Connect one more application, that may do more than listen."""
        async with connect(url.replace("http", "ws", 1), max_queue=None, proxy=None, **options) as socket:
            witness = make(self, socket)
            self.witnesses.append(witness)
            reading = asyncio.ensure_future(witness.read())
            try:
                if extended:
                    await witness.ask("openrois.hello", version="1")
                yield witness
            finally:
                await socket.close()
                await reading

    def bound(self, component_ref: str, witness: "Witness") -> None:
        """Note that a bind was answered OK (I3)."""
        holder = self.holders.get(component_ref)
        assert holder is None or holder is witness, f"{component_ref} has two holders"
        self.holders[component_ref] = witness

    def released(self, component_ref: str, witness: "Witness") -> None:
        """Note that a release was answered OK."""
        if self.holders.get(component_ref) is witness:
            del self.holders[component_ref]

    def check(self) -> None:
        """Judge what was received, when all connections have ended (I1, I2, I4, I7)."""
        for witness in self.witnesses:
            witness.check()


class Witness:
    """An application on a bare WebSocket that records all messages.

    Attributes:
        gone: its connection has ended.
        close_code: how.
        close_reason: why.
        events: results of the events that it heard, in order.
        dropped: how many events it was told that it missed.
        declined: the components that it asked for and was not given.
    """

    def __init__(self, book: Book, socket: ClientConnection) -> None:
        self.gone = asyncio.Event()
        self.close_code = 0
        self.close_reason = ""
        self.events: list[dict[str, Any]] = []
        self.errors: list[dict[str, Any]] = []
        self.dropped = 0
        self.declined: list[str] = []
        self.socket = socket
        self.reasons: dict[str, str] = {}
        self._book = book
        self._asked: dict[int, tuple[str, dict[str, Any]]] = {}
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._responses: Counter[int] = Counter()
        self._accepted: dict[str, None] = {}
        self._ends: dict[str, list[str]] = {}
        self._ended: dict[str, asyncio.Event] = {}
        self._subscriptions: set[str] = set()
        self._said: list[str] = []
        self._news = asyncio.Event()

    @property
    def was_cut(self) -> bool:
        """Whether the connection ended otherwise than by the application's own farewell."""
        return self.socket.close_code != 1000

    async def read(self) -> None:
        """Record messages until the connection ends."""
        try:
            while True:
                raw = await self.socket.recv()
                assert isinstance(raw, str)
                self._said.append(raw)
                self._take(json.loads(raw))
        except ConnectionClosed as closed:
            frame = closed.rcvd
            self.close_code, self.close_reason = (frame.code, frame.reason) if frame is not None else (1006, "")
        finally:
            self.gone.set()
            for answer in self._answers.values():
                if not answer.done():
                    answer.cancel()
            self._news.set()

    def _take(self, message: dict[str, Any]) -> None:
        if "method" in message:
            self._hear(message["method"], message["params"])
        else:
            self._respond(message)
        self._news.set()

    def _respond(self, message: dict[str, Any]) -> None:
        request_id = message["id"]
        assert request_id in self._asked, f"a response without a request: {request_id!r}"
        self._responses[request_id] += 1
        assert self._responses[request_id] == 1, f"{request_id!r} was answered twice (I1)"
        method, params = self._asked[request_id]
        if "result" in message:
            check_result(method, message["result"])
            self._note(method, params, message["result"])
        answer = self._answers.pop(request_id)
        if not answer.done():
            answer.set_result(message)

    def _note(self, method: str, params: dict[str, Any], result: dict[str, Any]) -> None:
        if result.get("return_code") != "OK":
            return
        if method == "rois.command.bind":
            self._book.bound(params["component_ref"], self)
        elif method == "rois.command.release":
            self._book.released(params["component_ref"], self)
        elif method == "rois.command.execute":
            for item in params["command_unit_list"]:
                for unit in item.get("command_list", [item]):
                    self._accept(unit["command_id"])
        elif method == "rois.command.set_parameter":
            self._accept(result["command_id"])
        elif method == "rois.event.subscribe":
            self._subscriptions.add(result["subscribe_id"])
        elif method == "rois.event.unsubscribe":
            self._subscriptions.discard(params["subscribe_id"])

    def _accept(self, command_id: str) -> None:
        assert command_id not in self._ends, f"{command_id!r} ended before it was accepted (I2)"
        self._accepted[command_id] = None
        self._book.accepted += 1

    def _hear(self, method: str, params: dict[str, Any]) -> None:
        check_notification(method, params)
        if method == "rois.command.completed":
            ends = self._ends.setdefault(params["command_id"], [])
            ends.append(params["status"])
            assert len(ends) == 1, f"{params['command_id']!r} ended twice: {ends} (I2)"
            self._ended.setdefault(params["command_id"], asyncio.Event()).set()
        elif method == "rois.event.notify_event":
            assert params["subscribe_id"] in self._subscriptions, "an event without a subscription (I4)"
            self.events.append(params)
        elif method == "rois.system.notify_error":
            self.errors.append(params)
        elif method == "openrois.events_dropped":
            self.dropped += params["count"]
        elif method == "openrois.lease.declined":
            self.declined.append(params["component_ref"])
        elif method == "openrois.reason" and "command_id" in params:
            self.reasons[params["command_id"]] = params["reason"]

    async def begin(self, method: str, **params: Any) -> "asyncio.Future[dict[str, Any]]":
        """Send a request; return what will have its response."""
        request_id = len(self._asked) + 1
        answer: asyncio.Future[dict[str, Any]] = asyncio.get_running_loop().create_future()
        self._asked[request_id], self._answers[request_id] = (method, params), answer
        try:
            await self.socket.send(json.dumps({"jsonrpc": "2.0", "id": request_id, "method": method, "params": params}))
        except ConnectionClosed:
            answer.cancel()
        return answer

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Ask and return the result."""
        async with asyncio.timeout(PATIENCE):
            message = await (await self.begin(method, **params))
        result: dict[str, Any] = message["result"]
        return result

    async def code(self, method: str, **params: Any) -> str:
        """Ask and return the return code."""
        return str((await self.ask(method, **params))["return_code"])

    async def bind(self, component_ref: str = "robot/lamp") -> str:
        return await self.code("rois.command.bind", component_ref=component_ref)

    async def execute(self, command_id: str, command_type: str = "start", component_ref: str = "robot/lamp") -> str:
        unit = {"component_ref": component_ref, "command_type": command_type, "command_id": command_id, "arguments": []}
        return await self.code("rois.command.execute", command_unit_list=[unit])

    async def subscribe(self, event_type: str, component_ref: str) -> str:
        condition = f"component_ref = '{component_ref}'"
        return str((await self.ask("rois.event.subscribe", event_type=event_type, condition=condition))["subscribe_id"])

    async def status(self, component_ref: str = "robot/lamp") -> str:
        """Return what `component_status` says, or the code of its refusal."""
        condition = f"component_ref = '{component_ref}'"
        result = await self.ask("rois.query.query", query_type="component_status", condition=condition)
        return str(result["results"][0]["value"] if result["results"] else result["return_code"])

    async def end_of(self, command_id: str, within: float = PATIENCE) -> str:
        """Wait until a command has ended and return how."""
        async with asyncio.timeout(within):
            await self._ended.setdefault(command_id, asyncio.Event()).wait()
        return self._ends[command_id][0]

    async def error(self, error_type: str = "COMPONENT_NOT_RESPONDING", within: float = PATIENCE) -> dict[str, Any]:
        """Wait for a `notify_error` of this kind, and take it."""
        async with asyncio.timeout(within):
            while True:
                for error in self.errors:
                    if error["error_type"] == error_type:
                        self.errors.remove(error)
                        return error
                self._news.clear()
                await self._news.wait()

    async def attached(self, engine_id: str = "robot") -> None:
        """Wait until an engine is there."""
        async with asyncio.timeout(PATIENCE):
            while engine_id not in await self._engines():  # noqa: ASYNC110 - an unconnected application gets no notification
                await asyncio.sleep(0.01)

    async def _engines(self) -> list[str]:
        below = (await self.ask("rois.system.get_profile", condition=""))["profile"]["sub_profiles"]
        return [each["identifier"]["code"] for each in below]

    def inherits(self, former: "Witness") -> None:
        """Go on where another one was cut off: what that one began ends here."""
        for command_id in former.unfinished():
            self._accepted[command_id] = None
        if self._book.holders.get("robot/lamp") is former:
            self._book.holders["robot/lamp"] = self

    def check(self) -> None:
        """Judge what was received, when the connection has ended (I1, I2, I7)."""
        if not self.was_cut:
            never = [self._asked[number] for number in self._asked if not self._responses[number]]
            assert not never, f"never answered: {never} (I1)"
            assert not self.unfinished(), f"never ended: {self.unfinished()} (I2)"
        for text in self._said:
            for word in _NEVER_SAID:
                assert word not in text, f"{word!r} in {text[:300]} (I7)"

    def unfinished(self) -> list[str]:
        """Return the accepted commands without an end."""
        return [command_id for command_id in self._accepted if command_id not in self._ends]

    @property
    def accepted(self) -> tuple[str, ...]:
        """The commands that were accepted."""
        return tuple(self._accepted)

    def how(self, command_id: str) -> str:
        """Return how a command has ended; empty where it has not."""
        return self._ends[command_id][0] if command_id in self._ends else ""

    async def settled(self) -> None:
        """Wait until every command has ended; a connection that is over brings no more."""
        async with asyncio.timeout(PATIENCE):
            while self.unfinished() and not self.gone.is_set():
                self._news.clear()
                await self._news.wait()


@asynccontextmanager
async def calm(log: pytest.LogCaptureFixture, longest: float = LONGEST_BLOCK) -> AsyncIterator[None]:
    """Check that meanwhile no task fails unheard and nothing keeps the loop busy (I10), and that all ends (I5)."""
    # What was there before is not looked at again: that would take longer than all the rest.
    gc.freeze()
    descriptors, loop = _descriptors(), asyncio.get_running_loop()
    unheard: list[str] = []
    loop.set_exception_handler(lambda _loop, context: unheard.append(str(context)))
    before = asyncio.all_tasks()
    busy = asyncio.ensure_future(_watch_turns(longest))
    try:
        yield
    finally:
        busy.cancel()
        with suppress(asyncio.CancelledError):
            await busy
    gc.collect()
    gc.unfreeze()
    await asyncio.sleep(0)
    assert not unheard, f"{unheard} (I10)"
    failed = [record.getMessage() for record in log.records if record.exc_info or "never retrieved" in record.message]
    assert not failed, f"{failed} (I10)"
    left = {task for task in asyncio.all_tasks() - before if not task.done()}
    assert not left, f"{left} (I5)"
    loop.set_exception_handler(None)
    async with asyncio.timeout(PATIENCE):
        # What was closed a moment ago may be closed by the loop's next turns.
        while _descriptors() > descriptors:  # noqa: ASYNC110 - the kernel sends no event
            await asyncio.sleep(0.01)


def _descriptors() -> int:
    return sum(1 for _ in Path("/proc/self/fd").iterdir())


async def _watch_turns(longest: float) -> None:
    """Look every few milliseconds at how much processor time the loop has had since the last look (I10).

    What the host of a virtual machine takes in a turn counts as the turn's, so a turn that is too long is excused by as
    much as was taken.
    """
    while True:
        taken = _taken_by_the_host()
        # To read that takes long beside a turn.
        for _ in range(20):
            began = time.thread_time()
            await asyncio.sleep(0.002)
            took = time.thread_time() - began
            if took >= longest:
                took -= _taken_by_the_host() - taken
            assert took < longest, f"the loop was busy for {took * 1000:.0f} ms without a pause (I10)"


def _taken_by_the_host() -> float:
    """Return for how many seconds, of all processors, others had them since this machine was started; 0 if unknown."""
    return float(getattr(psutil.cpu_times(), "steal", 0.0))


def check_audit(path: Path, *, commands: int) -> None:
    """Read the audit trail: one JSON object a line, in order, and every command that began is in it (I9)."""
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    times = [line["time"] for line in lines]
    assert times == sorted(times), "out of order (I9)"
    assert not [line for line in lines if line["kind"] == "lost"], "records were lost (I9)"
    begun = [line for line in lines if line["kind"] == "acted" and line["method"] == "rois.command.execute"]
    assert len(begun) <= commands, "more commands began than were accepted (I9)"
