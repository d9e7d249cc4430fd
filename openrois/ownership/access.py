"""How a gateway asks the store: each step and each call has its end, and failures are known and said once."""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Final, TypeVar

from openrois.errors import StoreUnreachable
from openrois.ownership.contact import Contact
from openrois.ownership.errors import GatewayReplaced

__all__ = ["StoreAccess"]

_log = logging.getLogger(__name__)

_STEP: Final = 0.45
"""Share of the patience for one step at the store, so that an unknown write is read again within it."""

_AT_ONCE: Final = 4
"""Calls that are under way at once; others wait for their turn."""

T = TypeVar("T")


class StoreAccess:
    """The way of one gateway to the store.

    Args:
        name: of the store, for sentences.
        ttl: seconds for which claims hold after a renewal.
        patience: seconds in which a call has its result or its error.
        clock: monotonic seconds.

    Attributes:
        problem: why the store cannot be used; empty where it can.
        steps: number of steps that were asked.
        seconds: how long they took together.
        failures: how many of them failed, or were given up.
    """

    def __init__(self, name: str, ttl: float, patience: float, clock: Callable[[], float]) -> None:
        self.problem = ""
        self.steps = 0
        self.seconds = 0.0
        self.failures = 0
        self._name = name
        self._patience = patience
        self._clock = clock
        self._contact = Contact(ttl)
        self._places = asyncio.Semaphore(_AT_ONCE)
        self._is_replaced = False

    @property
    def contact(self) -> float:
        """Seconds for which the contact with the store has lasted without a break."""
        return self._contact.lasting(self._clock())

    def note_answer(self, now_ms: int, *, has_lost_renewal: bool) -> None:
        """Note the store's clock in an answer, and whether the store has lost what this gateway renewed before."""
        if has_lost_renewal:
            # Maybe it has lost renewals of owners, too.
            self._contact.break_off()
        self._contact.note_answer(self._clock(), now_ms)

    def note_replaced(self, error: GatewayReplaced) -> None:
        """Note that another process runs as this gateway, which does not change any more."""
        if not self._is_replaced:
            _log.error("%s", error)
        self._is_replaced, self.problem = True, str(error)

    @asynccontextmanager
    async def bounded(self, *, is_urgent: bool = False) -> AsyncIterator[None]:
        """End what runs in the block when the patience is over; at most so many blocks that are not urgent run at once.

        Raises:
            StoreUnreachable: it was over.
        """
        is_asking = is_urgent
        try:
            async with asyncio.timeout(self._patience):
                if is_urgent:
                    yield
                else:
                    async with self._places:
                        is_asking = True
                        yield
        except TimeoutError:
            if is_asking:
                raise self._fail(self._patience) from None
            raise StoreUnreachable(f"{self._name} is busy with other engines: dial again") from None

    async def ask(self, step: Awaitable[T], seconds: float | None = None) -> T:
        """Return the result of one step at the store.

        Args:
            step: what is asked.
            seconds: in which it has its result; None for a share of the patience.

        Raises:
            StoreUnreachable: it failed, or did not answer in time; whether it was made is not known.
        """
        started = self._clock()
        seconds = self._patience * _STEP if seconds is None else seconds
        try:
            async with asyncio.timeout(seconds):
                result = await step
        except TimeoutError:
            raise self._fail(seconds) from None
        except StoreUnreachable as error:
            self._note_failure(error)
            raise
        finally:
            self.steps += 1
            self.seconds += self._clock() - started
        if self.problem and not self._is_replaced:
            _log.info("%s answers again", self._name)
            self.problem = ""
        return result

    def _fail(self, seconds: float) -> StoreUnreachable:
        error = StoreUnreachable(f"{self._name} did not answer within {seconds:.2g} s")
        self._note_failure(error)
        return error

    def _note_failure(self, error: StoreUnreachable) -> None:
        self.failures += 1
        self._contact.break_off()
        if self._is_replaced:
            return
        if not self.problem:
            _log.warning("%s; engines that are owned go on, and no other is claimed", error)
        self.problem = str(error)
