"""Commands that another run accepted: a former one of this gateway, or another gateway; how each ended. Pure."""

from collections import OrderedDict
from dataclasses import dataclass
from typing import Final

from openrois.errors import ComponentFailed
from openrois.journal.records import storable
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = ["GATEWAY_LOST", "MAX_FORMER", "RESTARTED", "FormerCommand", "FormerCommands"]

MAX_FORMER: Final = 16_384
"""Commands of former runs that are kept; of more the oldest are dropped."""

RESTARTED: Final = "the gateway was restarted"
"""The reason of the end of a command that ran then."""

GATEWAY_LOST: Final = "the gateway that ran the command was lost"
"""The same, where gateways are several."""

_NOT_KEPT: Final = "the command ended OK, and what it gave was too long for the journal"


@dataclass(slots=True)
class FormerCommand:
    """One command.

    Attributes:
        component_ref: what it was for.
        status: how it ended; None where its gateway ended first, or where it runs.
        reason: why not OK, or empty.
        kept: what it gave; None where that was too long to be kept.
        is_notified: its end was notified, which happens once.
        is_running: it has no end yet, and runs at a gateway that is there.
    """

    component_ref: str
    status: CompletedStatus | None
    reason: str
    kept: tuple[Result, ...] | None
    is_notified: bool = False
    is_running: bool = False

    @property
    def completed_status(self) -> CompletedStatus:
        """Its status, as in `completed`."""
        return CompletedStatus.ERROR if self.status is None else self.status

    def results(self) -> tuple[Result, ...]:
        """Return its results: none where it failed.

        Raises:
            ComponentFailed: they are lost, because its gateway ended while it ran, or they were too long.
        """
        if self.status is None:
            raise ComponentFailed(self.reason)
        if self.kept is None:
            raise ComponentFailed(_NOT_KEPT)
        return self.kept


class FormerCommands:
    """The commands of former runs, by the subject that started them and their id."""

    def __init__(self, most: int = MAX_FORMER) -> None:
        self._most = most
        self._commands: OrderedDict[tuple[str, str], FormerCommand] = OrderedDict()

    def __len__(self) -> int:
        return len(self._commands)

    def put(self, subject: str, command_id: str, command: FormerCommand) -> None:
        """Add a command; two of one subject with one id cannot be told apart, and the later stands for both."""
        self._commands[subject, command_id] = command
        self._commands.move_to_end((subject, command_id))
        if len(self._commands) > self._most:
            self._commands.popitem(last=False)

    def find(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return the command that `subject` started under this id, if there is one."""
        return self._commands.get((storable(subject), storable(command_id)))
