"""The commands of one application: ids in use, and results of finished commands. Pure."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from openrois.aio.bounded_history import BoundedHistory
from openrois.commands.quota import AcceptedTogether, Allowance, CommandQuota
from openrois.errors import BadParameter
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = ["MAX_ID", "MAX_RUNNING", "MAX_RUNNING_TEXT", "STOP_RESERVE", "CommandHistory"]

MAX_FINISHED: Final = 4096
MAX_RUNNING: Final = 1024
MAX_RUNNING_TEXT: Final = 8 * 1024 * 1024
"""Bytes that are kept of the unfinished commands of one application."""
MAX_ID: Final = 1024
"""Characters of an id: those of unfinished commands are kept, however many applications choose them."""
STOP_RESERVE: Final = 64
"""Commands `stop` of one application that may run beyond all limits: a flood must not keep what it started going."""
RECENT: Final = 10.0
"""Seconds for which a command counts as being on its component after its end: news of what went wrong takes time."""


@dataclass(slots=True)
class _Finished:
    component_ref: str
    at: float
    results: tuple[Result, ...]
    status: CompletedStatus
    reason: str


class CommandHistory:
    """Command ids belong to the application that chose them: two applications may use the same one.

    Args:
        clock: monotonic seconds.
        budget: shared by all applications of the engine.
        most_running: how many of it this one may use; so many results are remembered, too, as all may end at once.
        most_text: bytes of it that may be kept of this one's commands.
    """

    def __init__(
        self,
        clock: Callable[[], float],
        budget: CommandQuota,
        most_running: int = MAX_RUNNING,
        most_text: int = MAX_RUNNING_TEXT,
    ) -> None:
        self._clock = clock
        self._budget = budget
        self._own = Allowance("one application", most_running, most_text)
        self._running: dict[str, str] = {}
        self._together: dict[str, AcceptedTogether] = {}
        self._finished: BoundedHistory[_Finished] = BoundedHistory(max(MAX_FINISHED, most_running))

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running or command_id in self._finished

    def accept(
        self, commands: Mapping[str, str], beyond: int = 0, *, text: int = 0, subject: str | None = None
    ) -> None:
        """Note commands as running, all or none.

        Args:
            commands: the component_ref of each, by command_id.
            beyond: how many more than usual may run: for what ends others.
            text: bytes that are kept until the last of them has finished.
            subject: counts against its share; None for a client without a share.

        Raises:
            OutOfResources: more commands would run than are allowed, or more would be kept of them.
        """
        together = self._budget.accept_commands(self._own, len(commands), text, subject, beyond)
        self._running.update(commands)
        self._together.update(dict.fromkeys(commands, together))

    def finish(
        self,
        command_id: str,
        results: tuple[Result, ...],
        status: CompletedStatus = CompletedStatus.OK,
        reason: str = "",
    ) -> None:
        """Note how a running command has finished; the oldest of too many finished ones is forgotten."""
        component_ref = self._running.pop(command_id)
        self._together.pop(command_id).end_one()
        self._finished.put(command_id, _Finished(component_ref, self._clock(), results, status, reason), results)

    def results(self, command_id: str, sees: Callable[[str], bool] = lambda _component_ref: True) -> tuple[Result, ...]:
        """Return the results of a command: none while it runs and when it failed.

        Args:
            command_id: the command.
            sees: tells whether the component that it is of is in the application's scope, which may have changed.

        Raises:
            BadParameter: no command with this id is remembered, or its component is out of scope by now.
        """
        finished = self._finished.get(command_id)
        component_ref = self._running.get(command_id) if finished is None else finished.component_ref
        if component_ref is None or not sees(component_ref):
            raise BadParameter(f"there is no command {command_id[:200]!r}")
        return () if finished is None else finished.results

    @property
    def unfinished(self) -> int:
        """Number of commands that were accepted and have not finished."""
        return len(self._running)

    def ending(self, command_id: str) -> tuple[CompletedStatus, str] | None:
        """Return the status and reason of a finished command; None where no such command is kept."""
        finished = self._finished.get(command_id)
        return None if finished is None else (finished.status, finished.reason)

    def components(self) -> Iterator[str]:
        """Yield the component of each command that runs, or did so until a moment ago."""
        yield from self._running.values()
        oldest = self._clock() - RECENT
        for finished in self._finished.newest_first():
            if finished.at < oldest:
                return
            yield finished.component_ref
