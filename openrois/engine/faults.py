"""Faults that this process notices: each gets an id, and their rate is bounded."""

import logging
import time
from collections.abc import Callable, Iterable
from typing import Final

from openrois.aio.rate import RateLimit
from openrois.contract import Fault
from openrois.observability.logs import Tally
from openrois.types.codes import ErrorType
from openrois.types.references import new_id
from openrois.types.values import date_time

__all__ = ["FAULTS_AT_ONCE", "FAULTS_PER_SECOND", "FaultMint", "fault_limit"]

_log = logging.getLogger(__name__)

FAULTS_AT_ONCE: Final = 100
FAULTS_PER_SECOND: Final = 10.0
"""Faults of one engine that are notified; more are counted and logged."""

MAX_DESCRIPTION: Final = 1000
"""Characters of a fault's description; a component may raise with any text."""


def fault_limit(clock: Callable[[], float] = time.monotonic) -> RateLimit:
    """Return the bound on the faults of one engine."""
    return RateLimit(FAULTS_AT_ONCE, FAULTS_PER_SECOND, clock)


class FaultMint:
    """Makes the faults of one engine.

    Args:
        engine_id: leads the error ids.
        wall_clock: epoch seconds, for the time of a fault.
        clock: monotonic seconds, for the bound.
    """

    def __init__(
        self,
        engine_id: str,
        wall_clock: Callable[[], float] = time.time,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._engine_id = engine_id
        self._wall_clock = wall_clock
        self._limit = fault_limit(clock)
        self._untold = Tally(_log, f"faults of {engine_id} that were not reported, too many at a time", logging.WARNING)

    @property
    def untold(self) -> int:
        """Number of faults that were not notified because there were too many."""
        return self._untold.count

    def make(self, error_type: ErrorType, component_ref: str, description: str) -> Fault | None:
        """Return a new fault, or None where there are too many."""
        if not self._limit.admits():
            self._untold.note(description[:200])
            return None
        return self._new(error_type, component_ref, description)

    def make_each(self, error_type: ErrorType, component_refs: Iterable[str], description: str) -> tuple[Fault, ...]:
        """Return a fault of each component, or none where there are too many; one cause counts once."""
        if not self._limit.admits():
            self._untold.note(description[:200])
            return ()
        return tuple(self._new(error_type, ref, description) for ref in component_refs)

    def _new(self, error_type: ErrorType, component_ref: str, description: str) -> Fault:
        return Fault(
            error_id=new_id(self._engine_id),
            error_type=error_type,
            component_ref=component_ref,
            description=description[:MAX_DESCRIPTION],
            timestamp=date_time(self._wall_clock()),
        )
