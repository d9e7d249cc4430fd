"""Commands that run in a remote engine, until the other side has said how each of them ended."""

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from openrois.errors import Aborted
from openrois.logs import Tally
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Completed

__all__ = ["RemoteCommand", "RemoteCommands"]


_log = logging.getLogger(__name__)


class RemoteCommand:
    """One command.

    Args:
        component_ref: where it runs.

    Attributes:
        ended: how it ended; None where the engine went away first.
        reason: why it did not end OK, where the other side has said so.
        is_stopped: its component was told to stop before it was sent.
    """

    def __init__(self, component_ref: str) -> None:
        self.component_ref = component_ref
        self.ended: asyncio.Future[CompletedStatus | None] = asyncio.get_running_loop().create_future()
        self.reason = ""
        self.is_stopped = False

    def end(self, status: CompletedStatus | None) -> None:
        """Note how it ended; only the first time counts."""
        if not self.ended.done():
            self.ended.set_result(status)


class RemoteCommands:
    """The commands of one connection that have not ended, by the id that the other side knows them by.

    Args:
        before: called right before one is sent.

    Attributes:
        strays: ends that came for none of them: late, twice or invented. They change nothing.
    """

    def __init__(self, before: Callable[[], None]) -> None:
        self._before = before
        self.strays = Tally(_log, "ends of commands that nobody waits for")
        self._running: dict[str, RemoteCommand] = {}
        self._unsent: set[RemoteCommand] = set()

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running

    def __len__(self) -> int:
        return len(self._running)

    def expect(self, command_id: str, command: RemoteCommand) -> None:
        """Note a command before its end can be told."""
        self._running[command_id] = command

    def wait(self, command: RemoteCommand) -> None:
        """Note a command that is to be sent as soon as there is room."""
        self._unsent.add(command)

    def send(self, command: RemoteCommand) -> None:
        """Note that a command is sent now.

        Raises:
            Aborted: its component was told to stop while it waited for that, and must not begin behind the stop.
        """
        self._unsent.discard(command)
        if command.is_stopped:
            raise Aborted(f"{command.component_ref} was stopped before the command could be sent")
        self._before()

    def stop(self, component_ref: str) -> None:
        """Keep the commands of a component from being sent that still wait for that."""
        for command in self._unsent:
            if command.component_ref == component_ref:
                command.is_stopped = True

    def forget(self, command_id: str, command: RemoteCommand) -> None:
        """Forget a command that nobody waits for any more."""
        self._running.pop(command_id, None)
        self._unsent.discard(command)

    def take_completed(self, params: dict[str, Any]) -> None:
        """Take how a command ended; one that nobody waits for is passed over."""
        completed = Completed.model_validate(params)
        command = self._running.get(completed.command_id)
        if command is None:
            self.strays.note(completed.command_id[:80])
        else:
            command.end(completed.status)

    def take_reason(self, command_id: str, reason: str) -> None:
        """Take why a command is about to end otherwise than OK."""
        command = self._running.get(command_id)
        if command is not None:
            command.reason = reason

    def lost(self) -> None:
        """End all: the other side is gone."""
        for command in self._running.values():
            command.end(None)
