"""Our own requests on one connection: the futures that wait for answers, and the effect of an answer that is late."""

import asyncio
import logging
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, Final, NamedTuple

from openrois.jsonrpc.protocol import ErrorResponse, Params, Peer, RequestId, Response

__all__ = ["Calls", "RpcError", "SessionClosed"]

_log = logging.getLogger(__name__)

MAX_LATE: Final = 1024
"""Abandoned requests whose late answer still matters; the oldest of more is forgotten."""

_SHOWN: Final = 3
_LONGEST: Final = 300

OnResult = Callable[[Any], Any]
OnLate = Callable[[Any], None]
OnReason = Callable[[str], None]


class RpcError(Exception):
    """The other side answered with a JSON-RPC error.

    Attributes:
        code: its code.
        data: what else it said; what is wrong with params is a list of `{path, message}`.
    """

    def __init__(self, code: int, message: str, data: Any = None) -> None:
        super().__init__(f"{message} ({code}){_details(data)}")
        self.code = code
        self.data = data


class SessionClosed(Exception):
    """The connection ended before the answer came, or had ended before the question was asked."""


class _Waiter(NamedTuple):
    method: str
    answer: asyncio.Future[Any]
    on_result: OnResult | None
    on_late: OnLate | None
    on_reason: OnReason | None


class Calls:
    """The requests of `peer` that wait for their answers."""

    def __init__(self, peer: Peer) -> None:
        self._peer = peer
        self._waiters: dict[int, _Waiter] = {}
        self._late: OrderedDict[int, OnLate] = OrderedDict()

    def __len__(self) -> int:
        return len(self._waiters)

    def open(
        self,
        name: str,
        params: Params,
        on_result: OnResult | None,
        on_late: OnLate | None,
        on_reason: OnReason | None = None,
    ) -> tuple[int, str, asyncio.Future[Any]]:
        """Return a new request's id, its text, and the future that its answer settles."""
        request_id, text = self._peer.request(name, params)
        answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiters[request_id] = _Waiter(name, answer, on_result, on_late, on_reason)
        return request_id, text, answer

    def explain(self, request_id: RequestId, reason: str) -> None:
        """Note the reason of a refusal that follows; unknown requests are ignored."""
        waiter = self._waiters.get(request_id) if isinstance(request_id, int) else None
        if waiter is not None and waiter.on_reason is not None:
            waiter.on_reason(reason)

    def settle(self, response: Response) -> None:
        """Settle a request: `on_result` turns the answer into the value, or `on_late` gets it if that is too late."""
        waiter = self._waiters.pop(response.id, None)
        if waiter is None or waiter.answer.done():
            on_late = waiter.on_late if waiter is not None else self._late.pop(response.id, None)
            self._take_late(on_late, response.result)
            return
        try:
            result = response.result if waiter.on_result is None else waiter.on_result(response.result)
        except Exception as error:
            waiter.answer.set_exception(error)
        else:
            waiter.answer.set_result(result)

    def _take_late(self, on_late: OnLate | None, result: Any) -> None:
        if on_late is None:
            return
        try:
            on_late(result)
        except Exception as error:
            _log.info("a late answer could not be handled: %s", error)

    def refuse(self, refusal: ErrorResponse) -> None:
        """Fail a request with a JSON-RPC error."""
        self._late.pop(refusal.id, None)
        waiter = self._waiters.pop(refusal.id, None)
        if waiter is not None and not waiter.answer.done():
            waiter.answer.set_exception(RpcError(refusal.code, f"{waiter.method}: {refusal.message}", refusal.data))

    def abandon(self, request_id: int) -> None:
        """Stop waiting, if the answer has not come: it is dropped, or passed to `on_late`."""
        waiter = self._waiters.pop(request_id, None)
        if waiter is None:
            return
        if waiter.on_late is None:
            self._peer.abandon_request(request_id)
            return
        self._late[request_id] = waiter.on_late
        if len(self._late) > MAX_LATE:
            oldest, _ = self._late.popitem(last=False)
            self._peer.abandon_request(oldest)

    def fail(self, reason: str) -> None:
        """Fail every request with `SessionClosed`: no answer will come any more."""
        for waiter in self._waiters.values():
            if not waiter.answer.done():
                waiter.answer.set_exception(SessionClosed(reason))
        self._waiters.clear()
        self._late.clear()


def _details(data: Any) -> str:
    """Return the problem of params as the end of a sentence; the other side may send anything as `data`."""
    wrong = [each for each in data if isinstance(each, dict)] if isinstance(data, list) else []
    told = "; ".join(f"{each.get('path', '')}: {each.get('message', '')}" for each in wrong[:_SHOWN])
    return f": {' '.join(told.split())[:_LONGEST]}" if told else ""
