"""When an encoder that many viewers share is made to produce a key frame. Pure: the time is an argument."""

from enum import Enum

START_INTERVAL = 0.1
"""Seconds between two key frames for viewers that start; those who wait share one."""

REPAIR_INTERVAL = 1.0
"""Seconds between two key frames for viewers that lost data. A browser without a picture asks five times a second."""

STILL_SPACING = 0.6
"""Seconds between two key frames for viewers that are sent single pictures: as many as lie between the earliest time at
which such a viewer takes one and the time at which it asks, so that none waits because another has just been served."""


class KeyFrameCause(Enum):
    """Why a viewer needs a key frame."""

    START = "start"
    """It joins, resumes, or changes to this rendition."""
    REPAIR = "repair"
    """It lost data (PLI, FIR, or an overflow of its queue)."""
    STILL = "still"
    """It is sent single pictures, and the next one is due."""


# In the order of precedence: a frame that can serve both is taken from the budget of the starts.
_BUDGETS = (
    (KeyFrameCause.START, START_INTERVAL),
    (KeyFrameCause.REPAIR, REPAIR_INTERVAL),
    (KeyFrameCause.STILL, STILL_SPACING),
)


class KeyFrameBudget:
    """The budgets of one rendition, one for each cause.

    They are kept apart, so that a viewer that asks for repairs without end never makes another one wait for its start.
    A key frame serves everybody who asked before it, whatever it was made for.
    """

    __slots__ = ("_last", "_pending", "_under_way")

    def __init__(self) -> None:
        self._pending: set[KeyFrameCause] = set()
        self._under_way: set[KeyFrameCause] = set()
        """What was taken, as long as no key frame has come."""
        self._last: dict[KeyFrameCause, float] = {}

    def request(self, cause: KeyFrameCause) -> None:
        """Note that a viewer needs a key frame."""
        self._pending.add(cause)

    @property
    def is_asked(self) -> bool:
        """Whether a viewer that asked for a key frame has not had one since."""
        return bool(self._pending)

    def take(self, now: float) -> KeyFrameCause | None:
        """Decide on the frame that is encoded next: the cause it must be a key frame for, or None.

        `now` is in seconds and never goes back. All that was requested so far counts as served by that frame.
        """
        for cause, interval in _BUDGETS:
            if cause in self._pending and now - self._last.get(cause, float("-inf")) >= interval:
                self._last[cause] = now
                self._under_way |= self._pending
                self._pending.clear()
                return cause
        return None

    def restart(self) -> None:
        """Note that an encoder begins: what the one before it was asked for, and has not made, is asked of this one."""
        self._pending |= self._under_way
        self._under_way.clear()

    def served(self) -> None:
        """Note that a key frame has just gone to every viewer: nobody who asked until now needs another."""
        self._pending.clear()
        self._under_way.clear()
