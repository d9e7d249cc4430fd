"""How much of each turn of the event loop goes to datagrams: what is left waits until everything else had its turn.

A reader of a queue that is not empty does not suspend: without these bounds a peer connection's backlog would be worked
off in one turn, and commands would wait for it.
"""

import asyncio
import itertools
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Final

from openrois_streaming.network.admission import AdmissionSettings, TotalAdmission

DATAGRAMS_PER_TURN: Final = 32
"""Datagrams of one peer connection that are worked off in one turn."""

TIME_PER_TURN: Final = 0.002
"""Seconds of one turn that go to the datagrams of all peer connections; the one that is begun is finished."""

DEFERRED_LIMIT: Final = 256
"""Connectivity checks that may wait for a later turn, of all peer connections; then the newest are dropped."""


class Turns:
    """The turns of the event loop that runs, as far as they matter to whatever works off datagrams.

    Args:
        clock: monotonic seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.number = 0
        """Grows whenever a turn in which datagrams were worked off, or waited for the next one, is over."""
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
        """Have this turn count: something is worked off in it."""
        if not self._ending:
            self._ending = True
            asyncio.get_running_loop().call_soon(self._end)

    def spend(self, seconds: float) -> None:
        """Take so much of this turn."""
        self.begin()
        self._spent += seconds

    async def next(self) -> None:
        """Wait for a later turn with time left, behind all that have been waiting for longer."""
        ticket = next(self._tickets)
        while True:
            self.begin()
            waiting = asyncio.get_running_loop().create_future()
            self._waiting.append((ticket, waiting))
            await waiting
            if not self.is_spent:
                return

    def do(self, work: Callable[[], None]) -> bool:
        """Do `work` now, or in order in a later turn where this one is spent; False if too much waits already."""
        if not self.is_spent and not self._deferred:
            self._do(work)
        elif len(self._deferred) < DEFERRED_LIMIT:
            self.begin()
            self._deferred.append(work)
        else:
            return False
        return True

    def _do(self, work: Callable[[], None]) -> None:
        began = self.clock()
        work()
        self.spend(self.clock() - began)

    def _end(self) -> None:
        self._ending = False
        self.number += 1
        self._spent = 0.0
        waiting, self._waiting = sorted(self._waiting), []
        for _, each in waiting:
            if not each.done():
                each.set_result(None)
        while self._deferred and not self.is_spent:
            self._do(self._deferred.popleft())
        if self._deferred:
            self.begin()


class TurnTaking:
    """Receives the datagrams of one peer connection, and suspends its reader before a turn has had too many.

    Args:
        turns: of the event loop.
        receive: waits for the next datagram; suspends only where there is none.
    """

    def __init__(self, turns: Turns, receive: Callable[[], Awaitable[bytes]]) -> None:
        self._turns = turns
        self._receive = receive
        self._turn = -1
        self._worked_off = 0
        self._handed_out_at: float | None = None
        self._kept: bytes | None = None
        """What has come and waits for a turn, though its reader may give up: DTLS does when it is to repeat itself."""

    async def receive(self) -> bytes:
        """Wait for the next datagram; the one before is worked off now."""
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
    """What all peer connections of an engine have in common where datagrams come in.

    Args:
        settings: how much is admitted.
        clock: monotonic seconds.
    """

    def __init__(self, settings: AdmissionSettings | None = None, clock: Callable[[], float] = time.monotonic) -> None:
        self.total = TotalAdmission(settings or AdmissionSettings(), clock)
        self.turns = Turns(clock)
