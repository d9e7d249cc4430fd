"""Commands that were accepted and have not ended, of all applications: they can be ended from outside."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["PendingCommand", "PendingCommands"]


@dataclass(eq=False, slots=True)
class PendingCommand:
    """One command.

    Attributes:
        component_ref: where it runs, or will.
        owner: the session that sent it.
        end: ends it with ABORT and a reason before its turn has come.
        sequence: the number of the sequence that it belongs to, in the order of acceptance.
        starts: whether it starts the component.
        task: runs it; None before its turn.
        stopping: why its component is being stopped; empty unless it is.
        aborted: why it was ended from outside; empty unless it was.
    """

    component_ref: str
    owner: object
    end: Callable[[str], None]
    sequence: int = 0
    starts: bool = False
    task: asyncio.Task[Any] | None = None
    stopping: str = ""
    aborted: str = ""

    def abort(self, reason: str) -> None:
        """End it with ABORT; only the first time counts."""
        if self.aborted:
            return
        self.aborted = reason
        if self.task is None:
            self.end(reason)
        else:
            self.task.cancel()

    def takes_back_cancellation(self) -> bool:
        """Tell, in its task when that is cancelled, whether `abort` is all that has cancelled it; it then runs on."""
        return bool(self.aborted) and self.task is not None and self.task.uncancel() == 0


class PendingCommands:
    """The commands of one engine.

    Attributes:
        stops: how the stops will end that are to begin, by their component.
        stopping: how those will end that have begun; the last one of each component.
    """

    def __init__(self) -> None:
        self.stops: dict[str, asyncio.Future[str]] = {}
        self.stopping: dict[str, asyncio.Future[str]] = {}
        self._by_component: dict[str, set[PendingCommand]] = {}
        self._sequences = 0

    def next_sequence(self) -> int:
        """Return the number of a sequence that is accepted now."""
        self._sequences += 1
        return self._sequences

    def add(self, command: PendingCommand) -> None:
        """Note a command until `remove`."""
        self._by_component.setdefault(command.component_ref, set()).add(command)

    def remove(self, command: PendingCommand) -> None:
        """Remove a command that has ended."""
        commands = self._by_component[command.component_ref]
        commands.remove(command)
        if not commands:
            del self._by_component[command.component_ref]

    def stop(self, component_ref: str, before: int) -> None:
        """End what would start a component, was accepted before the sequence of this number, and waits for its turn.

        Sequences run side by side: a `stop` would overtake a `start` that waits for another command or for a delay.
        What a person means by it is that nothing runs afterwards.
        """
        for command in self.of(component_ref):
            if command.starts and command.task is None and command.sequence < before:
                command.abort(f"{component_ref} was stopped before the turn of its start came")

    def of(self, component_ref: str) -> tuple[PendingCommand, ...]:
        """Return the commands of a component."""
        return tuple(self._by_component.get(component_ref, ()))

    def components(self) -> tuple[str, ...]:
        """Return the components that have commands."""
        return tuple(self._by_component)
