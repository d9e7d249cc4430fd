"""Real CPU time of what runs in virtual time, by the account that each callback is charged to."""

import asyncio
import gc
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Final

__all__ = ["PEERS", "Account", "Meter", "Reading", "charged"]


class Account:
    """What callbacks are charged to.

    Attributes:
        name: for tables.
        ticks: nanoseconds so far, of a clock that also runs while another process has the processor.
    """

    __slots__ = ("name", "ticks")

    def __init__(self, name: str) -> None:
        self.name = name
        self.ticks = 0


PEERS: Final = Account("peers")
"""The account of what is charged to no other: scripted peers."""

charged: Final[ContextVar[Account]] = ContextVar("charged")
"""The account of what runs: tasks and timers inherit it."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What a meter shows.

    Attributes:
        cpu: processor seconds of the process.
        at: nanoseconds of a clock that also runs while another process has the processor.
        ticks: nanoseconds of that clock that each account was charged.
    """

    cpu: float
    at: int
    ticks: Mapping[Account, int]

    def seconds_since(self, former: "Reading") -> dict[Account, float]:
        """Return the processor seconds of each account between two readings.

        A clock that is cheap to read times each callback, and the processor time of the process corrects the sums.
        """
        passed = self.at - former.at
        share = (self.cpu - former.cpu) / passed if passed else 0.0
        return {account: (ticks - former.ticks.get(account, 0)) * share for account, ticks in self.ticks.items()}


class Meter:
    """Charges callbacks. What the loop takes between them is charged to no account.

    Args:
        ticks: nanoseconds.
        cpu: processor seconds of the process.
    """

    def __init__(
        self, ticks: Callable[[], int] = time.perf_counter_ns, cpu: Callable[[], float] = time.process_time
    ) -> None:
        self._ticks = ticks
        self._cpu = cpu
        self._accounts: set[Account] = set()
        self._collecting = 0
        self._collection_began = 0

    def run(self, handle: asyncio.Handle) -> None:
        """Run a callback of a loop, and charge the account of its context."""
        account = handle._context.get(charged, PEERS)  # type: ignore[attr-defined]
        self._accounts.add(account)
        began = self._ticks() - self._collecting
        handle._run()
        account.ticks += self._ticks() - self._collecting - began

    @contextmanager
    def watching_collector(self) -> Iterator[None]:
        """Charge no account what the garbage collector takes while the block runs.

        Here one collector goes over the objects of all gateways, and takes more than those of each would.
        """
        gc.callbacks.append(self._collected)
        try:
            yield
        finally:
            gc.callbacks.remove(self._collected)

    def _collected(self, phase: str, _info: Mapping[str, int]) -> None:
        if phase == "start":
            self._collection_began = self._ticks()
        else:
            self._collecting += self._ticks() - self._collection_began

    def read(self) -> Reading:
        """Return what has been charged so far."""
        return Reading(self._cpu(), self._ticks(), {account: account.ticks for account in self._accounts})
