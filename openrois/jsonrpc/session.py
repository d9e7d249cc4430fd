"""One JSON-RPC connection at work: a `Peer` over a `MessageStream`, with its tasks, waiters and bounds.

Both sides may ask and tell. Three orders are kept, because callers build on them: messages leave in the order they were
put; a reply leaves before the notifications that its call causes (`Reply.then`); and replies and notifications that
arrive are offered in the order of arrival (`on_result` runs before the next message is looked at).
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

from pydantic import BaseModel, ValidationError

from openrois.jsonrpc import protocol
from openrois.jsonrpc.outbox import Outbox, OutboxOverflow
from openrois.jsonrpc.protocol import Peer
from openrois.transport.stream import MessageStream, StreamClosed

__all__ = [
    "Handler",
    "InvalidParams",
    "NotificationHandler",
    "Reply",
    "RpcError",
    "RpcSession",
    "SessionClosed",
    "method",
]

_log = logging.getLogger(__name__)

MAX_RUNNING_REQUESTS: Final = 256
"""Requests of one connection that run at a time; while they do, no further message is read."""

CALL_TIMEOUT: Final = 10.0
"""Seconds that a call of ours waits for its answer."""

_FLUSH_TIMEOUT: Final = 1.0


@dataclass(frozen=True, slots=True)
class Reply:
    """A result, and what to do once it stands in the outbox: notifications put there come after it."""

    result: Any
    then: Callable[[], None]


Handler = Callable[[dict[str, Any]], Awaitable[Any]]
"""Answers one method: params in, the result or a `Reply` out."""

NotificationHandler = Callable[[dict[str, Any]], None]
"""Takes one notification; must not block."""


class InvalidParams(Exception):
    """The params do not fit the method: answered with -32602.

    Attributes:
        problems: a list of `{"path": dotted path, "message": sentence}`.
    """

    def __init__(self, problems: list[dict[str, str]]) -> None:
        super().__init__("; ".join(f"{problem['path']}: {problem['message']}" for problem in problems))
        self.problems = problems


class RpcError(Exception):
    """The other side answered with a JSON-RPC error."""

    def __init__(self, code: int, message: str, data: Any = None) -> None:
        super().__init__(f"{message} ({code})")
        self.code = code
        self.data = data


class SessionClosed(Exception):
    """The connection ended before the answer came, or had ended before the question was asked."""


class _MethodNotFound(Exception):
    """Nobody serves the method that was asked."""


class _Ended(Exception):
    """Leaves the task group, which cancels what still runs."""


Params = TypeVar("Params", bound=BaseModel)


def method(model: type[Params], function: Callable[[Params], Awaitable[Any]]) -> Handler:
    """Return a handler that reads its params with `model` and writes a model it gets back as a JSON object."""

    async def handle(params: dict[str, Any]) -> Any:
        try:
            checked = model.model_validate(params)
        except ValidationError as error:
            raise InvalidParams([_problem(entry) for entry in error.errors(include_url=False)]) from None
        return await function(checked)

    return handle


def _problem(entry: Any) -> dict[str, str]:
    return {"path": ".".join(str(part) for part in entry["loc"]), "message": entry["msg"]}


@dataclass(slots=True)
class _Waiter:
    answer: asyncio.Future[Any]
    on_result: Callable[[Any], None] | None


@dataclass
class RpcSession:
    """A JSON-RPC connection; `run` does the work and ends with the connection.

    Attributes:
        stream: what it speaks over; closed when `run` ends.
        methods: what the other side may ask.
        notifications: what the other side may tell; unknown ones are dropped.
    """

    stream: MessageStream
    methods: Mapping[str, Handler] = field(default_factory=dict)
    notifications: Mapping[str, NotificationHandler] = field(default_factory=dict)
    outbox: Outbox = field(default_factory=Outbox)

    def __post_init__(self) -> None:
        self._peer = Peer()
        self._waiters: dict[int, _Waiter] = {}
        self._slots = asyncio.Semaphore(MAX_RUNNING_REQUESTS)
        self._closed: StreamClosed | None = None

    async def run(self) -> StreamClosed:
        """Serve until the connection ends and return why it did.

        When it ends every unanswered call of ours fails once with `SessionClosed`, and the handlers that still run are
        cancelled before `run` returns.
        """
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._write())
                try:
                    await self._read(tasks)
                except StreamClosed as closed:
                    self._closed = self._closed or closed
                raise _Ended
        except* _Ended:
            pass
        finally:
            self._closed = self._closed or StreamClosed(1006)
            self._fail_waiters()
        return self._closed

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Send what waits, for at most a second, and close; `run` then ends by itself."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_FLUSH_TIMEOUT):
                await self.outbox.drained()
        self._closed = self._closed or StreamClosed(code, reason)
        await self.stream.close(code, reason)

    async def _read(self, tasks: asyncio.TaskGroup) -> None:
        while True:
            match self._peer.receive(await self.stream.receive()):
                case protocol.Request() as request:
                    await self._slots.acquire()
                    tasks.create_task(self._serve(request))
                case protocol.Notification(name, params):
                    self._take_notification(name, params)
                case protocol.Response(request_id, result):
                    self._settle(request_id, result)
                case protocol.ErrorResponse(request_id, code, message, data):
                    self._refuse(request_id, RpcError(code, message, data))
                case protocol.Violation(reason, answer):
                    _log.info("protocol violation: %s", reason)
                    if answer is not None:
                        self._put(answer)

    async def _write(self) -> None:
        while True:
            text = await self.outbox.get()
            try:
                await self.stream.send(text)
            except StreamClosed:
                return

    async def _serve(self, request: protocol.Request) -> None:
        try:
            self._answer(request.id, await self._handle(request))
        except InvalidParams as error:
            self._put(Peer.error(request.id, protocol.INVALID_PARAMS, "Invalid params", error.problems))
        except _MethodNotFound:
            self._put(Peer.error(request.id, protocol.METHOD_NOT_FOUND, "Method not found"))
        except Exception:
            _log.exception("%s failed", request.method)
            self._put(Peer.error(request.id, protocol.INTERNAL_ERROR, "Internal error"))
        finally:
            self._slots.release()

    async def _handle(self, request: protocol.Request) -> Any:
        handler = self.methods.get(request.method)
        if handler is None:
            raise _MethodNotFound
        return await handler(request.params)

    def _answer(self, request_id: protocol.RequestId, result: Any) -> None:
        then = None
        if isinstance(result, Reply):
            result, then = result.result, result.then
        if isinstance(result, BaseModel):
            result = result.model_dump(mode="json")
        self._put(Peer.response(request_id, result))
        if then is not None:
            then()

    def _take_notification(self, name: str, params: dict[str, Any]) -> None:
        handler = self.notifications.get(name)
        if handler is None:
            return
        try:
            handler(params)
        except Exception:
            _log.exception("the notification %s could not be taken", name)

    def _settle(self, request_id: int, result: Any) -> None:
        waiter = self._waiters.pop(request_id)
        if waiter.answer.done():
            return
        try:
            if waiter.on_result is not None:
                waiter.on_result(result)
        except Exception as error:
            waiter.answer.set_exception(error)
        else:
            waiter.answer.set_result(result)

    def _refuse(self, request_id: int, error: RpcError) -> None:
        waiter = self._waiters.pop(request_id)
        if not waiter.answer.done():
            waiter.answer.set_exception(error)

    def _fail_waiters(self) -> None:
        for waiter in self._waiters.values():
            if not waiter.answer.done():
                waiter.answer.set_exception(SessionClosed(str(self._closed)))
        self._waiters.clear()

    def _put(self, text: str, *, droppable: bool = False) -> None:
        try:
            self.outbox.put(text, droppable=droppable)
        except OutboxOverflow as overflow:
            # The other side is not reading, so a closing handshake could not reach it either.
            _log.warning("connection aborted: %s", overflow)
            self._closed = self._closed or StreamClosed(1006, "outbox overflow")
            self.stream.abort()

    async def call(
        self,
        name: str,
        params: Mapping[str, Any],
        *,
        timeout: float = CALL_TIMEOUT,
        on_result: Callable[[Any], None] | None = None,
    ) -> Any:
        """Ask the other side and wait for its answer.

        Args:
            name: the method.
            params: its params.
            timeout: seconds to wait at most.
            on_result: called with the result before any later message of the other side is looked at.

        Returns:
            The result.

        Raises:
            RpcError: the other side answered with an error.
            SessionClosed: the connection ended first.
            TimeoutError: no answer in time; one that comes later is dropped.
        """
        if self._closed is not None:
            raise SessionClosed(str(self._closed))
        request_id, text = self._peer.request(name, params)
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiters[request_id] = _Waiter(answer, on_result)
        self._put(text)
        try:
            async with asyncio.timeout(timeout):
                return await answer
        finally:
            self._peer.forget(request_id)
            self._waiters.pop(request_id, None)

    def notify(self, name: str, params: Mapping[str, Any], *, droppable: bool = False) -> None:
        """Tell the other side; nothing happens when the connection has ended.

        Args:
            name: the method.
            params: its params.
            droppable: an event, which may be dropped when the other side reads too slowly.
        """
        if self._closed is None:
            self._put(Peer.notification(name, params), droppable=droppable)
