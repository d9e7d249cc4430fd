"""The order in which speeches are placed in time: each shortly before the one before it ends.

Not sooner, because a speech that was placed stays where it is when the one before it is cut off.
"""

import asyncio
from collections import deque
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois_body.sound.mixer import SoundBusy
from openrois_body.sound.playback import reach

__all__ = ["EARLY", "LONGEST_LINE", "Line", "Turn"]

LONGEST_LINE: Final = 32
"""Speeches that are played or wait."""
EARLY: Final = 0.2
"""Seconds before the end of a speech at which the next one is placed: time for a busy machine to do so."""


class Turn:
    """The place of one speech in the line."""

    def __init__(self, line: "Line") -> None:
        """Use `Line.join`."""
        self._line = line
        self._given_up = False
        self.ends_at: float | None = None
        """When the speech ends, on the media clock; None while that is not known."""
        self.news = asyncio.Event()
        """Set when it may have become its turn."""

    async def comes(self) -> bool:
        """Wait until the speech may be placed; returns False if it was given up before."""
        while not self._given_up:
            self.news.clear()
            due = self._line.due(self)
            if due is not None and due <= self._line.clock.now():
                return True
            if due is None:
                await self.news.wait()
            else:
                await reach(self._line.clock, due, self.news)
        return False

    def set_end(self, moment: float) -> None:
        """Set when the speech ends: the next one is placed shortly before."""
        self.ends_at = moment
        self._line.notify()

    def give_up(self) -> None:
        """Let `comes` return."""
        self._given_up = True
        self.news.set()

    def pass_on(self) -> None:
        """Leave the line: the speech is over, or will not be played. Idempotent."""
        self._line.leave(self)


class Line:
    """The line of the speeches of one voice, in the order in which they joined.

    Args:
        clock: the media clock.
    """

    def __init__(self, clock: MediaClock) -> None:
        self.clock = clock
        self._turns: deque[Turn] = deque()

    def join(self) -> Turn:
        """Return a place behind all others.

        Raises:
            SoundBusy: `LONGEST_LINE` speeches are played or wait already.
        """
        if len(self._turns) >= LONGEST_LINE:
            raise SoundBusy(f"{LONGEST_LINE} speeches wait already, which is the limit; wait until one has ended")
        turn = Turn(self)
        self._turns.append(turn)
        return turn

    def due(self, turn: Turn) -> float | None:
        """Return when a speech may be placed; None while that is not known."""
        before = self._turns.index(turn) - 1
        if before < 0:
            return self.clock.now()
        ends_at = self._turns[before].ends_at
        return None if ends_at is None else ends_at - EARLY

    def leave(self, turn: Turn) -> None:
        """Take a turn out of the line."""
        if turn in self._turns:
            self._turns.remove(turn)
            self.notify()

    def notify(self) -> None:
        """Let those that wait look again."""
        for each in self._turns:
            each.news.set()
