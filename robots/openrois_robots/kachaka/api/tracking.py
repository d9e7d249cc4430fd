"""Which commands have ended, from what the robot tells: the command that runs, and the one that ended last. Pure.

The robot tells the result of the last command alone. Where two end between two answers, that of the first is gone: its
command counts as lost a while after it was seen to run no more.
"""

from dataclasses import dataclass
from typing import Final

__all__ = ["LOST_AFTER", "Tracking"]

LOST_AFTER: Final = 0.7
"""Seconds after which a command that does not run any more, and whose result was not told, counts as lost."""


@dataclass(slots=True)
class _Tracked:
    """A command that was accepted.

    Attributes:
        was_seen: whether it was told as the one that runs.
        gone_at: since when it is not, although it should be; None while that is not so.
    """

    was_seen: bool = False
    gone_at: float | None = None


class Tracking:
    """The commands that were accepted and have not ended, by their ids."""

    def __init__(self) -> None:
        self._tracked: dict[str, _Tracked] = {}
        self._current = ""

    def __len__(self) -> int:
        return len(self._tracked)

    def __contains__(self, command_id: str) -> bool:
        return command_id in self._tracked

    @property
    def current(self) -> str:
        """The id of the command that ran when the robot told it last; empty: none."""
        return self._current

    def begin(self, command_id: str, now: float) -> None:
        """Note that the robot has accepted a command; it may have been told as the one that runs already."""
        self._tracked[command_id] = _Tracked()
        self.note_current(self._current, now)

    def note_end(self, command_id: str) -> None:
        """Forget a command."""
        self._tracked.pop(command_id, None)

    def note_current(self, command_id: str, now: float) -> None:
        """Note which command runs now; empty: none.

        A command that was never seen waits behind another one; where none runs it should.
        """
        self._current = command_id
        for each, tracked in self._tracked.items():
            if each == command_id:
                tracked.was_seen, tracked.gone_at = True, None
            elif (tracked.was_seen or not command_id) and tracked.gone_at is None:
                tracked.gone_at = now

    def lost(self, now: float) -> tuple[str, ...]:
        """Return the commands that have ended without a result."""
        return tuple(
            each
            for each, tracked in self._tracked.items()
            if tracked.gone_at is not None and now - tracked.gone_at >= LOST_AFTER
        )

    @property
    def misses(self) -> bool:
        """Whether a command does not run although it has not ended, so that time decides."""
        return any(tracked.gone_at is not None for tracked in self._tracked.values())
