"""The commands of one application: which ids are taken, and what finished commands gave."""

from collections import OrderedDict
from typing import Final

from openrois.errors import BadParameter, OutOfResources
from openrois.types.messages import Result

__all__ = ["CommandLog"]

MAX_FINISHED: Final = 4096
MAX_RUNNING: Final = 1024


class CommandLog:
    """Command ids belong to the application that chose them: two applications may use the same one."""

    def __init__(self, max_finished: int = MAX_FINISHED, max_running: int = MAX_RUNNING) -> None:
        self._running: set[str] = set()
        self._finished: OrderedDict[str, tuple[Result, ...]] = OrderedDict()
        self._max_finished = max_finished
        self._max_running = max_running

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running or command_id in self._finished

    def accept(self, command_ids: list[str]) -> None:
        """Note commands as running, all or none.

        Raises:
            OutOfResources: more commands would run than are allowed.
        """
        if len(self._running) + len(command_ids) > self._max_running:
            raise OutOfResources(f"at most {self._max_running} commands of one application run at a time")
        self._running.update(command_ids)

    def finish(self, command_id: str, results: tuple[Result, ...]) -> None:
        """Note a command as finished; the oldest of too many finished ones is forgotten."""
        self._running.discard(command_id)
        self._finished[command_id] = results
        while len(self._finished) > self._max_finished:
            self._finished.popitem(last=False)

    def results(self, command_id: str) -> tuple[Result, ...]:
        """Return what a command gave: empty while it runs and when it failed.

        Raises:
            BadParameter: no command with this id is remembered.
        """
        if command_id not in self:
            raise BadParameter(f"there is no command {command_id[:200]!r}")
        return self._finished.get(command_id, ())
