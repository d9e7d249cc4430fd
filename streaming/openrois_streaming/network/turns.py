"""Bounds on the part of each event loop turn that goes to datagrams, so that everything else has its turn.

A reader of a non-empty queue does not suspend: without these bounds a peer connection's backlog would be processed in
one turn, and commands would wait for it.
"""

import asyncio
import itertools
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Final

from openrois_streaming.network.admission import AdmissionSettings, TotalAdmission

DATAGRAMS_PER_TURN: Final = 32
"""Datagrams of one peer connection that are processed in one turn."""

TIME_PER_TURN: Final = 0.002
"""Seconds of one turn that go to the datagrams of all peer connections; the last one begun is finished."""

DEFERRED_LIMIT: Final = 256
"""Connectivity checks of all peer connections that may wait for a later turn; further ones are dropped."""


class Turns:
    """Turns of the running event loop, as readers of datagrams share them.

    Args:
        clock: monotonic seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.number = 0
        """Number of the turn; it grows after each turn in which datagrams were processed or awaited."""
        self.clock = clock
        self._spent = 0.0
        self._waiting: list[tuple[int, asyncio.Future[None]]] = []
        self._tickets = itertools.count()
        self._deferred: deque[Callable[[], None]] = deque()
        self._ending = False

    @property
    def is_spent(self) -> bool:
        """Whether this turn has no time left for datagrams."""
        return self._spent >= TIME_PER_TURN

    def begin(self) -> None:
        """Note that datagrams are processed in this turn."""
        if not self._ending:
            self._ending = True
            asyncio.get_running_loop().call_soon(self._finish_turn)

    def spend(self, seconds: float) -> None:
        """Charge so many seconds to this turn."""
        self.begin()
        self._spent += seconds

    async def next(self) -> None:
        """Wait for a later turn with time left, behind all earlier waiters."""
        ticket = next(self._tickets)
        while True:
            self.begin()
            waiting = asyncio.get_running_loop().create_future()
            self._waiting.append((ticket, waiting))
            await waiting
            if not self.is_spent:
                return

    def run_or_defer(self, work: Callable[[], None]) -> bool:
        """Run `work` now, or in order in a later turn if this one is spent; False if too much waits already."""
        if not self.is_spent and not self._deferred:
            self._run_now(work)
        elif len(self._deferred) < DEFERRED_LIMIT:
            self.begin()
            self._deferred.append(work)
        else:
            return False
        return True

    def _run_now(self, work: Callable[[], None]) -> None:
        began = self.clock()
        work()
        self.spend(self.clock() - began)

    def _finish_turn(self) -> None:
        self._ending = False
        self.number += 1
        self._spent = 0.0
        waiting, self._waiting = sorted(self._waiting), []
        for _, each in waiting:
            if not each.done():
                each.set_result(None)
        while self._deferred and not self.is_spent:
            self._run_now(self._deferred.popleft())
        if self._deferred:
            self.begin()


class TurnTaking:
    """Reader of the datagrams of one peer connection that suspends before a turn has had too many.

    Args:
        turns: the turns of the event loop.
        receive: waits for the next datagram; suspends only where there is none.
    """

    def __init__(self, turns: Turns, receive: Callable[[], Awaitable[bytes]]) -> None:
        self._turns = turns
        self._receive = receive
        self._turn = -1
        self._worked_off = 0
        self._handed_out_at: float | None = None
        self._kept: bytes | None = None
        """Datagram that waits for a turn although its reader may have given up, as DTLS does to retransmit."""

    async def receive(self) -> bytes:
        """Wait for the next datagram; the one before counts as processed."""
        turns = self._turns
        if self._handed_out_at is not None:
            if turns.number == self._turn:
                turns.spend(turns.clock() - self._handed_out_at)
            self._handed_out_at = None
        if self._turn == turns.number and self._worked_off >= DATAGRAMS_PER_TURN:
            await turns.next()
        if self._kept is None:
            self._kept = await self._receive()
        if turns.is_spent:
            await turns.next()
        data, self._kept = self._kept, None
        turns.begin()
        if self._turn != turns.number:
            self._turn, self._worked_off = turns.number, 0
        self._worked_off += 1
        self._handed_out_at = turns.clock()
        return data


class Ingress:
    """Limits and turns that all peer connections of an engine share for received datagrams.

    Args:
        settings: limits on what is admitted.
        clock: monotonic seconds.
        takes_turns: whether media is read in turns, beside others that need the event loop; an application reads its
            own at once, which costs less.
    """

    def __init__(
        self,
        settings: AdmissionSettings | None = None,
        clock: Callable[[], float] = time.monotonic,
        *,
        takes_turns: bool = True,
    ) -> None:
        self.total = TotalAdmission(settings or AdmissionSettings(), clock)
        self.turns = Turns(clock)
        self.takes_turns = takes_turns
