"""Commands that were accepted: each has a handle that can be awaited, and ends exactly once."""

import asyncio
from collections.abc import Awaitable, Callable, Generator, Iterable
from typing import Any, Final, Generic, TypeVar

from openrois.client.errors import ConnectionLost
from openrois.errors import Aborted, ComponentFailed, OutOfResources, RoISError, TimedOut
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Completed

__all__ = ["Command", "Commands", "Execution"]

MAX_RUNNING: Final = 4096
"""Commands of one client that may be unfinished; this project's gateway accepts fewer."""

T = TypeVar("T")

_ERRORS: Final[dict[CompletedStatus, type[RoISError]]] = {
    CompletedStatus.ERROR: ComponentFailed,
    CompletedStatus.ABORT: Aborted,
    CompletedStatus.OUT_OF_RESOURCES: OutOfResources,
    CompletedStatus.TIMEOUT: TimedOut,
}


class Command(Generic[T]):
    """A command that the gateway has accepted. Await it for its end and its results; any task may, at any time.

    It raises `Aborted`, `TimedOut`, `OutOfResources` or `ComponentFailed` where the command ended otherwise than OK,
    and `ConnectionLost` where the connection ended first: then the command may go on, and its end stays unknown.
    Cancelling the wait does not stop the command.

    Attributes:
        component_ref: the component that runs it.
        command_type: which command.
        command_id: what `Client.get_command_result` takes.
    """

    def __init__(
        self,
        component_ref: str,
        command_type: str,
        command_id: str,
        read: Callable[[str], Awaitable[T]],
    ) -> None:
        self.component_ref = component_ref
        self.command_type = command_type
        self.command_id = command_id
        self._read = read
        self._ended = asyncio.Event()
        self._outcome: CompletedStatus | ConnectionLost | None = None
        self._reason = ""

    def __repr__(self) -> str:
        outcome = "running" if self._outcome is None else self.status or "lost"
        return f"<Command {self.command_type} of {self.component_ref}: {outcome}>"

    @property
    def done(self) -> bool:
        """Whether it has ended, or its end cannot be known any more."""
        return self._outcome is not None

    @property
    def status(self) -> CompletedStatus | None:
        """Its status at the end; None while it runs and when the connection ended first."""
        return self._outcome if isinstance(self._outcome, CompletedStatus) else None

    def explain(self, reason: str) -> None:
        """Note the reason of an end other than OK, which follows."""
        self._reason = reason

    def settle(self, outcome: CompletedStatus | ConnectionLost) -> None:
        """Note its end; only the first time counts."""
        if self._outcome is None:
            self._outcome = outcome
            self._ended.set()

    @property
    def error(self) -> Exception | None:
        """The error that awaiting it raises, once it is done; None if it ended OK."""
        if isinstance(self._outcome, ConnectionLost):
            return self._outcome
        if self._outcome in (None, CompletedStatus.OK):
            return None
        unexplained = "; the log of its adapter says why" if self._outcome is CompletedStatus.ERROR else ""
        why = f": {self._reason}" if self._reason else unexplained
        return _ERRORS[self._outcome](f"{self.command_type} of {self.component_ref} ended {self._outcome}{why}")

    async def wait(self) -> None:
        """Wait until it has ended, with any status."""
        await self._ended.wait()

    def __await__(self) -> Generator[Any, None, T]:
        return self._result().__await__()

    async def _result(self) -> T:
        await self.wait()
        if (error := self.error) is not None:
            raise error
        return await self._read(self.command_id)


class Execution:
    """A sequence that the gateway has accepted. Await it for the end of all of its commands.

    It raises what the first command that failed raises; the commands after it end with `Aborted`.

    Attributes:
        commands: their handles, in order.
    """

    def __init__(self, commands: tuple[Command[Any], ...]) -> None:
        self.commands = commands

    def __await__(self) -> Generator[Any, None, None]:
        return self._finish().__await__()

    async def _finish(self) -> None:
        for command in self.commands:
            await command.wait()
        errors = [command.error for command in self.commands if command.error is not None]
        if errors:
            raise next((error for error in errors if not isinstance(error, Aborted)), errors[0])


class Commands:
    """The commands of one client that are not finished."""

    def __init__(self) -> None:
        self._running: dict[str, Command[Any]] = {}

    def __len__(self) -> int:
        return len(self._running)

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running

    def expect(self, commands: Iterable[Command[Any]]) -> None:
        """Note commands before they are sent, so that none can end unnoticed.

        Raises:
            OutOfResources: too many are unfinished.
        """
        new = {command.command_id: command for command in commands}
        if len(self._running) + len(new) > MAX_RUNNING:
            raise OutOfResources(f"{MAX_RUNNING} commands of this client are unfinished")
        self._running.update(new)

    def drop_commands(self, commands: Iterable[Command[Any]]) -> None:
        """Drop commands that were not accepted."""
        for command in commands:
            self._running.pop(command.command_id, None)

    def explain(self, command_id: str, reason: str) -> None:
        """Note the reason of an end other than OK; unknown commands are ignored."""
        command = self._running.get(command_id)
        if command is not None:
            command.explain(reason)

    def completed(self, told: Completed) -> None:
        """Note the end of a command; unknown commands are ignored."""
        command = self._running.pop(told.command_id, None)
        if command is not None:
            command.settle(told.status)

    def ids(self) -> tuple[str, ...]:
        """Return the ids of those that are not finished."""
        return tuple(self._running)

    def lost(self, reason: str, command_ids: Iterable[str] | None = None) -> None:
        """Fail commands, all unless some are given: their end cannot be known any more."""
        for command_id in self.ids() if command_ids is None else command_ids:
            command = self._running.pop(command_id, None)
            if command is None:
                continue
            command.settle(ConnectionLost(f"{command.command_type} of {command.component_ref}: {reason}"))
