"""Commands that run in a remote engine, until it has notified how each of them ended."""

import asyncio
import logging
import secrets
from collections.abc import Callable
from typing import Any, Final

from openrois.aio.bounded_history import BoundedHistory
from openrois.commands.history import MAX_ID
from openrois.errors import Aborted
from openrois.observability.logs import Tally
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Completed

__all__ = ["RemoteCommand", "RemoteCommands"]


_log = logging.getLogger(__name__)

MAX_USED: Final = 4096
"""Ids chosen by applications that are kept of one connection, so that none is sent twice."""
MAX_USED_TEXT: Final = 1024 * 1024
"""Characters of these ids."""


class RemoteCommand:
    """One command.

    Args:
        component_ref: where it runs.

    Attributes:
        ended: how it ended; None where the engine went away first.
        reason: why it did not end OK, where the other side has said so.
        is_stopped: its component was stopped, so that it must not be sent any more.
        command_id: the id that the other side knows it by; empty before that is settled.
    """

    def __init__(self, component_ref: str) -> None:
        self.component_ref = component_ref
        self.ended: asyncio.Future[CompletedStatus | None] = asyncio.get_running_loop().create_future()
        self.reason = ""
        self.is_stopped = False
        self.command_id = ""

    def record_end(self, status: CompletedStatus | None) -> None:
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
        self.strays = Tally(_log, "ends of commands that are not waited for")
        self._running: dict[str, RemoteCommand] = {}
        self._unsent: set[RemoteCommand] = set()
        self._used: BoundedHistory[None] = BoundedHistory(MAX_USED, MAX_USED_TEXT)

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._running

    def __len__(self) -> int:
        return len(self._running)

    def id_for(self, wanted: str) -> str:
        """Return the id under which a command is sent: the wanted one if it is free, else with a random suffix.

        An id is used once for as long as it is remembered: the end of a command that is not waited for any more must
        not be taken for that of another. Where `wanted` is empty, any id does.
        """
        if wanted and wanted not in self._used and wanted not in self._running:
            self._used.put(wanted, None, ())
            return wanted
        suffix = secrets.token_hex(16)
        return f"{wanted}-{suffix}" if 0 < len(wanted) < MAX_ID - len(suffix) else suffix

    def expect(self, command_id: str, command: RemoteCommand) -> None:
        """Add a command before its end can be notified."""
        command.command_id = command_id
        self._running[command_id] = command

    def wait(self, command: RemoteCommand) -> None:
        """Add a command that is to be sent as soon as there is room."""
        self._unsent.add(command)

    def send(self, command: RemoteCommand) -> None:
        """Note that a command is sent now.

        Raises:
            Aborted: its component was stopped while it waited for that, and it must not begin behind the stop.
        """
        self._unsent.discard(command)
        if command.is_stopped:
            raise Aborted(f"{command.component_ref} was stopped before the command could be sent")
        self._before()

    def stop(self, component_ref: str) -> None:
        """Keep the commands of a component from being sent that still wait for that, or would be sent once more."""
        for command in (*self._unsent, *self._running.values()):
            if command.component_ref == component_ref:
                command.is_stopped = True

    def forget_command(self, command: RemoteCommand) -> None:
        """Drop a command that is not waited for any more."""
        self._running.pop(command.command_id, None)
        self._unsent.discard(command)

    def handle_completed(self, params: dict[str, Any]) -> None:
        """Note how a command ended; unknown commands are ignored."""
        completed = Completed.read_newer(params)
        command = self._running.get(completed.command_id)
        if command is None:
            self.strays.note(completed.command_id[:80])
        else:
            command.record_end(completed.status)

    def take_reason(self, command_id: str, reason: str) -> None:
        """Note the reason of an end other than OK, which follows."""
        command = self._running.get(command_id)
        if command is not None:
            command.reason = reason

    def lost(self) -> None:
        """End all: the other side is gone."""
        for command in self._running.values():
            command.record_end(None)
