"""One JSON-RPC connection at work: a `Peer` over a `MessageStream`, with its tasks, waiters and bounds.

Both sides may send requests and notifications. Four orders are kept, because callers build on them: messages leave in
the order they were put; what explains a reply stands right before it (`Reply.reason`); a reply leaves before the
notifications that its call causes (`Reply.then`); and replies and notifications that arrive are offered in the order of
arrival (`on_result` runs before the next message is read).
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Final

from pydantic import ValidationError

from openrois.aio.loop_lag import STOOD_STILL
from openrois.jsonrpc import protocol
from openrois.jsonrpc.calls import Calls, RpcError, SessionClosed
from openrois.jsonrpc.handler import Handler, InvalidParams, NotificationHandler, Reply, method
from openrois.jsonrpc.latencies import Latencies
from openrois.jsonrpc.outbox import Outbox, OutboxOverflow
from openrois.jsonrpc.protocol import Peer, RequestId
from openrois.jsonrpc.read_budget import read_fairly
from openrois.jsonrpc.request_queue import QueueRules, RequestQueue
from openrois.jsonrpc.writing import Writer
from openrois.observability import correlation
from openrois.observability.logs import Tally
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

MAX_NAME: Final = 100
"""Characters of an unknown method in the error that names it."""

CALL_TIMEOUT: Final = 10.0
"""Seconds that a call of ours waits for its answer."""

_FLUSH_TIMEOUT: Final = 1.0


class _MethodNotFound(Exception):
    """The method that was asked is not served."""


class _Ended(Exception):
    """Leaves the task group, which cancels what still runs."""


@dataclass
class RpcSession:
    """A JSON-RPC connection; `run` does the work and ends with the connection.

    Attributes:
        stream: what it speaks over; its owner closes it after `run`.
        methods: handlers of the other side's requests.
        notifications: handlers of the other side's notifications; unknown ones are dropped.
        outbox: what waits to be sent.
        call_timeout: seconds that a call of ours waits for its answer.
        on_failure: called with what failed when a handler here raised what it must not raise, after that was logged.
        explain: called with the id of a request and a `Reply.reason` that is not empty; what it tells the other side
            stands right before the reply.
        rules: which requests come first and how many there may be; the `RequestQueue` made of them keeps count.
        on_refusal: called with the method, the params, the result and the reason of such a reply.
        latencies, call_latencies: of the requests that are served here, and of our own; None for not measured.
        peer: the name of the other end, for the log.
        requests: how many came.
        refused: how many of them were answered with a reason.
        failed: how many handlers raised what they must not raise.
        overflows: 1 if the connection was cut because the other side does not read.
    """

    stream: MessageStream
    methods: Mapping[str, Handler] = field(default_factory=dict)
    notifications: Mapping[str, NotificationHandler] = field(default_factory=dict)
    outbox: Outbox = field(default_factory=Outbox)
    call_timeout: float = CALL_TIMEOUT
    on_failure: Callable[[str], None] = lambda _what: None
    explain: Callable[[RequestId, str], None] = lambda _request_id, _reason: None
    on_refusal: Callable[[str, Mapping[str, Any], Any, str], None] = lambda _method, _params, _result, _reason: None
    rules: QueueRules = field(default_factory=QueueRules)
    latencies: Latencies | None = None
    call_latencies: Latencies | None = None
    peer: str = ""
    requests: int = field(default=0, init=False)
    refused: int = field(default=0, init=False)
    failed: int = field(default=0, init=False)
    overflows: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._peer = Peer()
        self._calls = Calls(self._peer)
        self._writer = Writer(self.stream, self.outbox)
        self._violations = Tally(_log, "protocol violations")
        self._closed: StreamClosed | None = None
        self._reading: asyncio.Timeout | None = None
        self._answered = 0
        self.request_queue = RequestQueue(
            lambda request, over: self._tasks.create_task(self._serve(request, over)), self._turn_away, self.rules
        )

    @property
    def closed(self) -> StreamClosed | None:
        """The reason for which the connection ended; None while it lives."""
        return self._closed

    @property
    def running(self) -> int:
        """Number of requests that are being served."""
        return self.requests - self._answered

    @property
    def unanswered(self) -> int:
        """Number of requests of our own that wait."""
        return len(self._calls)

    @property
    def violations(self) -> int:
        """Number of malformed messages."""
        return self._violations.count

    async def run(self) -> StreamClosed:
        """Serve until the connection ends and return why it did.

        When it ends every unanswered call of ours fails once with `SessionClosed`, and the handlers that still run are
        cancelled before `run` returns.
        """
        before = _cancellations()
        try:
            async with asyncio.TaskGroup() as self._tasks:
                self._tasks.create_task(self._writer.run())
                try:
                    await self._read()
                except StreamClosed as closed:
                    self._closed = self._closed or closed
                finally:
                    self.request_queue.close()
                raise _Ended
        except* _Ended:
            pass
        finally:
            self._closed = self._closed or StreamClosed(1006)
            self._calls.fail(str(self._closed))
            self.outbox.close()
        if _cancellations() > before:
            # A task group that ends by itself forgets that it is cancelled meanwhile: an adapter would dial for ever.
            raise asyncio.CancelledError
        return self._closed

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Send what waits, for at most a second, and close; `run` then ends by itself."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_FLUSH_TIMEOUT):
                await self.outbox.drained()
        self._closed = self._closed or StreamClosed(code, reason)
        await self.stream.close(code, reason)

    def end_session(self, code: int, reason: str) -> None:
        """Receive and send nothing more from now on: `run` ends with this, and the stream is its owner's to close."""
        if self._closed is None:
            self._closed = StreamClosed(code, reason)
            if self._reading is not None:
                self._reading.reschedule(0)

    async def _read(self) -> None:
        """Handle messages until the connection ends, or `end_session` ends it."""
        try:
            async with asyncio.timeout(None) as self._reading:
                await read_fairly(self.stream.receive, self._handle_text)
        except TimeoutError:
            if self._closed is None:
                raise
        finally:
            self._reading = None

    def _handle_text(self, text: str) -> None:
        match self._peer.receive(text):
            case protocol.Request() as request:
                self.request_queue.put_request(request, len(text))
            case protocol.Notification(name, params):
                self._take_notification(name, params)
            case protocol.Response() as response:
                self._calls.settle(response)
            case protocol.ErrorResponse() as refusal:
                self._calls.refuse(refusal)
            case protocol.Violation(reason, answer):
                self._violations.note(reason)
                if answer is not None:
                    self._put(answer)

    def _turn_away(self, request: protocol.Request, reason: str) -> None:
        """Refuse a request because there are too many."""
        result = self.rules.refusal(request.method)
        if result is None:
            answer = Peer.error(request.id, protocol.TOO_MANY_REQUESTS, "Too many requests", {"reason": reason})
        else:
            self._explain_refusal(request, result, reason)
            answer = Peer.response(request.id, result)
        self._put(answer)

    def _explain_refusal(self, request: protocol.Request, result: Any, reason: str) -> None:
        if isinstance(request.params, dict):
            self.refused += 1
            self.on_refusal(request.method, request.params, result, reason)
            self.explain(request.id, reason)

    async def _serve(self, request: protocol.Request, over: Callable[[], None]) -> None:
        correlation.serve(request.id)
        if _log.isEnabledFor(logging.DEBUG):
            _log.debug("asked for %.80s", request.method)
        started = perf_counter()
        self.requests += 1
        name = request.method if len(request.method) <= MAX_NAME else f"{request.method[:MAX_NAME]}..."
        reply = Reply(None)
        try:
            result = await _handled(self.methods, request)
            reply = result if isinstance(result, Reply) else Reply(result)
            answer = Peer.response(request.id, reply.result)
        except InvalidParams as error:
            answer = Peer.error(request.id, protocol.INVALID_PARAMS, f"Invalid params of {name}", error.problems)
        except _MethodNotFound:
            answer = Peer.error(request.id, protocol.METHOD_NOT_FOUND, f"Method not found: {name}")
        except Exception:
            self._failed(request.method)
            answer = Peer.error(request.id, protocol.INTERNAL_ERROR, "Internal error")
        finally:
            over()
        if reply.reason:
            self._explain_refusal(request, reply.result, reply.reason)
        self._put(answer)
        self._answered += 1
        if self.latencies is not None and request.method in self.methods:
            self.latencies.note(request.method, perf_counter() - started)
        if reply.then is not None:
            self._carry_out(request.method, reply.then)

    def _carry_out(self, name: str, then: Callable[[], None]) -> None:
        try:
            then()
        except Exception:
            # The reply has left, so this cannot be answered any more.
            self._failed(f"what follows the reply of {name}")

    def _take_notification(self, name: str, params: dict[str, Any]) -> None:
        handler = self.notifications.get(name)
        if handler is None:
            return
        try:
            handler(params)
        except ValidationError:
            self._violations.note(f"the params of the notification {name} do not fit")
        except Exception:
            self._failed(f"taking the notification {name}")

    def _failed(self, what: str) -> None:
        """Log the exception that is being handled, and report that there was one."""
        _log.exception("%s failed", what)
        self.failed += 1
        self.on_failure(what)

    def _put(self, text: str, *, droppable: bool = False) -> None:
        if self._closed is not None:
            return
        try:
            self._writer.put(text, droppable=droppable)
        except OutboxOverflow as overflow:
            self._cut(str(overflow))

    def cut_unread(self) -> None:
        """End the connection: others, which do read, need the room of what waits on it."""
        self._cut("too much waits unread on all connections, and most of it on this one")

    def _cut(self, reason: str) -> None:
        if self._closed is not None:
            return
        # It does not read, so a closing handshake could not reach it either.
        _log.warning("connection aborted: %s", reason)
        self.overflows = 1
        self._closed = StreamClosed(1006, "outbox overflow")
        self.outbox.close()
        self.stream.abort()

    async def call(
        self,
        name: str,
        params: protocol.Params,
        *,
        timeout: float | None = None,
        urgent: bool = False,
        before: Callable[[], None] | None = None,
        on_result: Callable[[Any], Any] | None = None,
        on_late: Callable[[Any], None] | None = None,
        on_reason: Callable[[str], None] | None = None,
    ) -> Any:
        """Send a request, wait for its answer and return the result.

        Args:
            name: the method.
            params: its params.
            timeout: seconds to wait at most, for room to ask as for the answer; `call_timeout` unless given.
            urgent: whether it is sent also where there is no room to ask.
            before: called when there is room, right before it is sent; what it raises is raised, and nothing is sent.
            on_result: turns the result into the return value, before any later message of the other side is read.
            on_late: called with a result that comes after the caller gave up, by timeout or cancellation; without it
                such a result is dropped.
            on_reason: called with what `handle_reason` gets for this request, before its result comes.

        Raises:
            RpcError: the other side answered with an error.
            SessionClosed: the connection ended first.
            TimeoutError: no answer in time.
        """
        loop = asyncio.get_running_loop()
        deadline = loop.time() + (self.call_timeout if timeout is None else timeout)
        if not urgent and not self.outbox.is_roomy:
            # A request can wait: many at once may not end the connection, as answers that are not read do.
            async with asyncio.timeout_at(deadline):
                await self.outbox.room()
        if self._closed is not None:
            raise SessionClosed(str(self._closed))
        if before is not None:
            before()
        request_id, text, answer = self._calls.open(name, params, on_result, on_late, on_reason)
        # `asyncio.timeout` takes as long as all the rest of a call.
        expiry = loop.call_at(deadline, _expire, answer, deadline)
        started = perf_counter()
        if _log.isEnabledFor(logging.DEBUG):
            _log.debug("asks %s for %s, as its request %d", self.peer or "the other side", name, request_id)
        try:
            self._put(text)
            return await answer
        finally:
            expiry.cancel()
            self._calls.abandon(request_id)
            if self.call_latencies is not None:
                self.call_latencies.note(name, perf_counter() - started)

    def handle_reason(self, request_id: RequestId, reason: str) -> None:
        """Note the reason of a refusal that follows; unknown requests are ignored."""
        self._calls.explain(request_id, reason)

    def post(self, name: str, params: protocol.Params) -> None:
        """Send a request and drop its answer; nothing happens when the connection has ended."""
        if self._closed is None:
            request_id, text, _ = self._calls.open(name, params, None, _ignore)
            self._calls.abandon(request_id)
            self._put(text)

    def notify(self, name: str, params: protocol.Params, *, droppable: bool = False, dispensable: bool = False) -> None:
        """Send a notification; nothing happens when the connection has ended.

        Args:
            name: the method.
            params: its params.
            droppable: an event, which may be dropped when the other side reads too slowly.
            dispensable: what is not worth the connection: left out while half of what may wait does already.
        """
        if self._closed is None and (self.outbox.is_roomy or not dispensable):
            self._put(Peer.notification(name, params), droppable=droppable)


def _handled(methods: Mapping[str, Handler], request: protocol.Request) -> Awaitable[Any]:
    handler = methods.get(request.method)
    if handler is None:
        raise _MethodNotFound
    if not isinstance(request.params, dict):
        raise InvalidParams([{"path": "", "message": "params must be an object"}])
    return handler(request.params)


def _expire(answer: asyncio.Future[Any], deadline: float) -> None:
    loop = answer.get_loop()
    if answer.done():
        return
    if loop.time() > deadline + STOOD_STILL:
        # This process stood still: the answer may have come meanwhile, and was not read.
        loop.call_later(STOOD_STILL, _expire, answer, loop.time() + STOOD_STILL)
    else:
        answer.set_exception(TimeoutError())


def _ignore(_result: Any) -> None:
    """Drop an answer that has no caller."""


def _cancellations() -> int:
    """Return how often the task that runs has been cancelled."""
    task = asyncio.current_task()
    return 0 if task is None else task.cancelling()
