"""Requests of a connection that run, wait or are refused: so many at a time, and urgent ones before all. Pure."""

from collections.abc import Callable
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Any, Final

from openrois.aio.lean_queue import LeanQueue
from openrois.aio.rate import RateLimit
from openrois.jsonrpc.protocol import Request

__all__ = ["MAX_RUNNING_REQUESTS", "QueueRules", "RequestQueue"]

MAX_RUNNING_REQUESTS: Final = 256
"""Requests of one connection that run at a time."""

MAX_WAITING_REQUESTS: Final = 16_384
"""Requests of one connection that wait until one has run; one more is refused."""

MAX_WAITING_TEXT: Final = 4 * 1024 * 1024
"""Characters of them all."""

MAX_URGENT_REQUESTS: Final = 64
"""Urgent requests of one connection that run beside those; one more is treated like any other."""


@dataclass(frozen=True, slots=True)
class QueueRules:
    """Rules for the requests of a connection: which are urgent, and what they concern.

    Attributes:
        is_urgent: whether a request passes all that wait and counts against no limit.
        meant: what an urgent request is about; nothing for anything.
        named: what a request that waits would act on, nothing for anything; None where it does not act. Behind an
            urgent one that is about the same it may not begin any more.
        refusal: returns the result of a method whose request is refused because there are too many; None for an error.
        rate: how often there may be one that is not urgent; None for as often as they like.
    """

    is_urgent: Callable[[Request], bool] = lambda _request: False
    meant: Callable[[Request], AbstractSet[str]] = lambda _urgent: frozenset()
    named: Callable[[Request], AbstractSet[str] | None] = lambda _waiting: None
    refusal: Callable[[str], Any] = lambda _method: None
    rate: RateLimit | None = None


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A request that waits. What it names is read once: urgent ones, which may be many, check all that wait."""

    request: Request
    length: int
    named: AbstractSet[str] | None

    def would_act_on(self, meant: AbstractSet[str]) -> bool:
        return self.named is not None and (not meant or not self.named or not self.named.isdisjoint(meant))


class RequestQueue:
    """The requests of one connection.

    Args:
        start: begins to serve a request; its second argument has to be called when that is over.
        refuse: answers a request with the reason why it will not be served.
        rules: what is special about them.

    Attributes:
        refused: how many requests were refused.
        urgent: how many passed the others.
    """

    def __init__(
        self,
        start: Callable[[Request, Callable[[], None]], object],
        refuse: Callable[[Request, str], None],
        rules: QueueRules,
    ) -> None:
        self._start = start
        self._refuse = refuse
        self._rules = rules
        self._running = 0
        self._running_urgent = 0
        self._waiting = LeanQueue[_Waiting]()
        self._text = 0
        self.refused = 0
        self.urgent = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def put_request(self, request: Request, length: int) -> None:
        """Take a request whose text has so many characters: start it, let it wait, or refuse it."""
        if self._running_urgent < MAX_URGENT_REQUESTS and self._rules.is_urgent(request):
            self._pass_all(request)
        elif self._rules.rate is not None and not self._rules.rate.admits():
            self._turn_away(request, f"too many requests a second; retry_after={self._rules.rate.wait():.3f}")
        elif self._running < MAX_RUNNING_REQUESTS:
            self._running += 1
            self._start(request, self._ran)
        elif len(self._waiting) < MAX_WAITING_REQUESTS and self._text + length <= MAX_WAITING_TEXT:
            self._waiting.put(_Waiting(request, length, self._rules.named(request)))
            self._text += length
        else:
            self._turn_away(request, f"{len(self._waiting)} requests wait already; retry_after=1")

    def close(self) -> None:
        """Start nothing more: the connection has ended."""
        self._waiting.clear()
        self._text = 0

    def _pass_all(self, request: Request) -> None:
        meant = self._rules.meant(request)
        overtaken = [each for each in self._waiting if each.would_act_on(meant)]
        if overtaken:
            # What was asked before a stop may not begin behind it.
            self._waiting = LeanQueue(each for each in self._waiting if not each.would_act_on(meant))
            self._text = sum(each.length for each in self._waiting)
        self.urgent += 1
        self._running_urgent += 1
        self._start(request, self._urgent_ran)
        for waiting in overtaken:
            self._turn_away(waiting.request, f"it waited when {request.method} came")

    def _turn_away(self, request: Request, reason: str) -> None:
        self.refused += 1
        self._refuse(request, reason)

    def _urgent_ran(self) -> None:
        self._running_urgent -= 1

    def _ran(self) -> None:
        if not self._waiting:
            self._running -= 1
            return
        waiting = self._waiting.pop()
        self._text -= waiting.length
        self._start(waiting.request, self._ran)
