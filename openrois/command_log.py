"""The commands of one application: which ids are taken, and what finished commands gave."""

from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from openrois.errors import BadParameter, OutOfResources
from openrois.types.messages import Result

__all__ = ["CommandLog"]

MAX_FINISHED: Final = 4096
MAX_RUNNING: Final = 1024
RECENT: Final = 10.0
"""Seconds for which a command counts as being on its component after its end: news of what went wrong takes time."""


@dataclass(slots=True)
class _Finished:
    component_ref: str
    at: float
    results: tuple[Result, ...]


class CommandLog:
    """Command ids belong to the application that chose them: two applications may use the same one."""

    def __init__(
        self, clock: Callable[[], float], max_finished: int = MAX_FINISHED, max_running: int = MAX_RUNNING
    ) -> None:
        self._clock = clock
        self._running: dict[str, str] = {}
        self._finished: OrderedDict[str, _Finished] = OrderedDict()
        self._max_finished = max_finished
        self._max_running = max_running

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running or command_id in self._finished

    def accept(self, commands: Mapping[str, str]) -> None:
        """Note commands as running, all or none.

        Args:
            commands: the component_ref of each, by command_id.

        Raises:
            OutOfResources: more commands would run than are allowed.
        """
        if len(self._running) + len(commands) > self._max_running:
            raise OutOfResources(f"at most {self._max_running} commands of one application run at a time")
        self._running.update(commands)

    def finish(self, command_id: str, results: tuple[Result, ...]) -> None:
        """Note a command as finished; the oldest of too many finished ones is forgotten."""
        component_ref = self._running.pop(command_id, "")
        self._finished[command_id] = _Finished(component_ref, self._clock(), results)
        while len(self._finished) > self._max_finished:
            self._finished.popitem(last=False)

    def results(self, command_id: str) -> tuple[Result, ...]:
        """Return what a command gave: empty while it runs and when it failed.

        Raises:
            BadParameter: no command with this id is remembered.
        """
        if command_id not in self:
            raise BadParameter(f"there is no command {command_id[:200]!r}")
        finished = self._finished.get(command_id)
        return () if finished is None else finished.results

    def has_one_on(self, component_ref: str) -> bool:
        """Tell whether a command runs on the component, or did so until a moment ago."""
        if component_ref in self._running.values():
            return True
        oldest = self._clock() - RECENT
        for finished in reversed(self._finished.values()):
            if finished.at < oldest:
                return False
            if finished.component_ref == component_ref:
                return True
        return False
