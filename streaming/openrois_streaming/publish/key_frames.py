"""Budgets of key frames of an encoder that many viewers share. Pure: the time is an argument."""

from enum import Enum

START_INTERVAL = 0.1
"""Seconds between two key frames for viewers that start; waiting viewers share one."""

REPAIR_INTERVAL = 1.0
"""Seconds between two key frames for viewers that lost data. A browser without a picture asks five times a second."""

STILL_SPACING = 0.6
"""Seconds between two key frames for viewers that are sent single pictures: the time between the earliest picture that
such a viewer takes and its next request, so that none waits because another has just been served."""


class KeyFrameCause(Enum):
    """Why a viewer needs a key frame."""

    START = "start"
    """The viewer joins, resumes, or changes to this rendition."""
    REPAIR = "repair"
    """The viewer lost data (PLI, FIR, or an overflow of its queue)."""
    STILL = "still"
    """The viewer is sent single pictures, and the next one is due."""


# In order of precedence: a frame that serves both is charged to the budget of starts.
_BUDGETS = (
    (KeyFrameCause.START, START_INTERVAL),
    (KeyFrameCause.REPAIR, REPAIR_INTERVAL),
    (KeyFrameCause.STILL, STILL_SPACING),
)


class KeyFrameBudget:
    """Budgets of one rendition, one for each cause.

    They are separate, so that a viewer that asks for repairs without end never delays another one's start. A key frame
    serves every viewer that asked before it, whatever its cause.
    """

    __slots__ = ("_last", "_pending", "_under_way")

    def __init__(self) -> None:
        self._pending: set[KeyFrameCause] = set()
        self._under_way: set[KeyFrameCause] = set()
        """Causes that were taken, until a key frame comes."""
        self._last: dict[KeyFrameCause, float] = {}

    def request(self, cause: KeyFrameCause) -> None:
        """Note that a viewer needs a key frame."""
        self._pending.add(cause)

    @property
    def is_asked(self) -> bool:
        """Whether a viewer waits for a key frame."""
        return bool(self._pending)

    def take_cause(self, now: float) -> KeyFrameCause | None:
        """Return the cause for which the next frame must be a key frame, or None.

        `now` is in seconds and never goes back. All requests so far count as served by that frame.
        """
        for cause, interval in _BUDGETS:
            if cause in self._pending and now - self._last.get(cause, float("-inf")) >= interval:
                self._last[cause] = now
                self._under_way |= self._pending
                self._pending.clear()
                return cause
        return None

    def restart(self) -> None:
        """Note that a new encoder begins: it inherits the unserved requests of the previous one."""
        self._pending |= self._under_way
        self._under_way.clear()

    def served(self) -> None:
        """Note that a key frame has just gone to every viewer, which serves all requests until now."""
        self._pending.clear()
        self._under_way.clear()
