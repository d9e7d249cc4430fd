"""The commands of one application: which ids are taken, and what finished commands gave."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from openrois.errors import BadParameter, OutOfResources
from openrois.remembered import Remembered
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = ["MAX_ID", "MAX_RUNNING", "MAX_UNFINISHED", "STOP_RESERVE", "CommandBudget", "CommandLog"]

MAX_FINISHED: Final = 4096
MAX_RUNNING: Final = 1024
MAX_ID: Final = 1024
"""Characters of an id: those of unfinished commands are kept, however many applications choose them."""
MAX_UNFINISHED: Final = 16_384
"""Commands of all applications, those that are gone included: what they started goes on, however long that takes."""
STOP_RESERVE: Final = 64
"""Commands `stop` of one application that may run beyond both limits: a flood must not keep what it started going."""
RECENT: Final = 10.0
"""Seconds for which a command counts as being on its component after its end: news of what went wrong takes time."""


@dataclass(slots=True)
class _Finished:
    component_ref: str
    at: float
    results: tuple[Result, ...]
    status: CompletedStatus
    reason: str


class CommandBudget:
    """How many commands of an engine are accepted and not finished yet, whoever started them."""

    def __init__(self, most: int = MAX_UNFINISHED) -> None:
        self.most = most
        self._left = most

    @property
    def taken(self) -> int:
        """How many are accepted and not finished."""
        return self.most - self._left

    def take(self, count: int, beyond: int = 0) -> None:
        """Count commands that are accepted, where there are enough left or `beyond` so many.

        Raises:
            OutOfResources: they are too many.
        """
        if count > self._left + beyond:
            raise OutOfResources("the engine has as many unfinished commands as it takes")
        self._left -= count

    def give_back(self) -> None:
        """Count one that is finished."""
        self._left += 1


class CommandLog:
    """Command ids belong to the application that chose them: two applications may use the same one.

    Args:
        clock: monotonic seconds.
        budget: shared by all applications of the engine.
        most_running: how many of it this one may use; so many results are remembered, too, as all may end at once.
    """

    def __init__(self, clock: Callable[[], float], budget: CommandBudget, most_running: int = MAX_RUNNING) -> None:
        self._clock = clock
        self._budget = budget
        self._most_running = most_running
        self._running: dict[str, str] = {}
        self._finished: Remembered[_Finished] = Remembered(max(MAX_FINISHED, most_running))

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running or command_id in self._finished

    def accept(self, commands: Mapping[str, str], beyond: int = 0) -> None:
        """Note commands as running, all or none.

        Args:
            commands: the component_ref of each, by command_id.
            beyond: how many more than usual may run: for what ends others.

        Raises:
            OutOfResources: more commands would run than are allowed.
        """
        if len(self._running) + len(commands) > self._most_running + beyond:
            raise OutOfResources(f"at most {self._most_running} commands of one application run at a time")
        self._budget.take(len(commands), beyond)
        self._running.update(commands)

    def finish(
        self,
        command_id: str,
        results: tuple[Result, ...],
        status: CompletedStatus = CompletedStatus.OK,
        reason: str = "",
    ) -> None:
        """Note how a running command has finished; the oldest of too many finished ones is forgotten."""
        component_ref = self._running.pop(command_id)
        self._budget.give_back()
        self._finished.put(command_id, _Finished(component_ref, self._clock(), results, status, reason), results)

    def results(self, command_id: str, sees: Callable[[str], bool] = lambda _component_ref: True) -> tuple[Result, ...]:
        """Return what a command gave: empty while it runs and when it failed.

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
        """How many commands were accepted and have not finished."""
        return len(self._running)

    def ending(self, command_id: str) -> tuple[CompletedStatus, str] | None:
        """Return how a command has finished and why so; None where none with this id that has is remembered."""
        finished = self._finished.get(command_id)
        return None if finished is None else (finished.status, finished.reason)

    def has_one_on(self, component_ref: str) -> bool:
        """Tell whether a command runs on the component, or did so until a moment ago."""
        if component_ref in self._running.values():
            return True
        oldest = self._clock() - RECENT
        for finished in self._finished.newest_first():
            if finished.at < oldest:
                return False
            if finished.component_ref == component_ref:
                return True
        return False
