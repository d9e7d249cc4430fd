"""What a gateway asks of its journal, wherever that is kept; and a journal that keeps nothing."""

from collections.abc import Mapping
from typing import Final, Protocol

from openrois.journal.former import FormerCommand
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = ["MAX_WAITING", "PATIENCE", "Journal", "NoJournal"]

MAX_WAITING: Final = 65_536
"""Records that wait to be written; one more is lost and counted."""

PATIENCE: Final = 0.25
"""Seconds that a command waits to be in the journal before it is accepted; then it goes on without."""


class Journal(Protocol):
    """Accepted commands, each with its one end, over restarts.

    What does not take its records stops no command: that is counted, logged once, and tried again.

    Attributes:
        lost: records that found no room.
        failures: how often records could not be written.
        failing: whether the last attempt failed.
        written: records that were written.
        late: commands that were accepted before they were written.
        engines: those that were attached when the last run of the gateway ended, and will come back to it.
    """

    lost: int
    failures: int
    failing: bool
    written: int
    late: int
    engines: frozenset[str]

    @property
    def waiting(self) -> int:
        """Number of records that wait to be written."""
        ...

    async def accepted(self, session: str, subject: str, commands: Mapping[str, str]) -> None:
        """Note commands that are about to be accepted; returns when they are written, or a moment later.

        Args:
            session: the connection that they came over; opaque.
            subject: that started them.
            commands: the component_ref of each, by command_id.
        """
        ...

    def ended(
        self, session: str, command_id: str, status: CompletedStatus, reason: str, results: tuple[Result, ...]
    ) -> None:
        """Note that a command has ended."""
        ...

    def engine(self, engine_id: str, *, is_there: bool) -> None:
        """Note that an engine was attached or detached."""
        ...

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command that another run accepted: a former one of this gateway, or another gateway.

        Raises:
            StoreUnreachable: the journal is elsewhere, and did not answer.
        """
        ...

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command of another run whose end was not notified yet, and note that it is from now on.

        Of several that ask, whatever gateway they ask, one gets it; none while the command still runs.

        Raises:
            StoreUnreachable: the journal is elsewhere, and did not answer; the end may count as notified.
        """
        ...


class NoJournal:
    """A `Journal` that keeps nothing: what a gateway has that was given none."""

    def __init__(self) -> None:
        self.lost = 0
        self.failures = 0
        self.failing = False
        self.written = 0
        self.late = 0
        self.engines: frozenset[str] = frozenset()
        self.waiting = 0

    async def accepted(self, session: str, subject: str, commands: Mapping[str, str]) -> None:
        """Keep nothing."""

    def ended(
        self, session: str, command_id: str, status: CompletedStatus, reason: str, results: tuple[Result, ...]
    ) -> None:
        """Keep nothing."""

    def engine(self, engine_id: str, *, is_there: bool) -> None:
        """Keep nothing."""

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        """Know no command."""
        return None

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        """Know no command."""
        return None
