"""The order in which speeches are placed in time: a speech waits until the end of the one before it is known."""

import asyncio
from collections import deque
from typing import Final

from openrois_body.sound.mixer import SoundBusy

__all__ = ["LONGEST_LINE", "Line", "Turn"]

LONGEST_LINE: Final = 32
"""Speeches that may wait for the end of those before them to be known."""


class Turn:
    """The place of one speech in the line."""

    def __init__(self, line: "Line") -> None:
        """Use `Line.join`."""
        self._line = line
        self._comes = asyncio.get_running_loop().create_future()
        self.is_over = False

    async def comes(self) -> bool:
        """Wait until the speech may be placed; returns False if it was given up before. Ends with `pass_on`."""
        return bool(await asyncio.shield(self._comes))

    def pass_on(self) -> None:
        """Let the next speech be placed: the end of this one is known, or it will not be played. Idempotent."""
        self.is_over = True
        self.settle(False)
        self._line.advance()

    def settle(self, came: bool) -> None:
        """Answer `comes`, once."""
        if not self._comes.done():
            self._comes.set_result(came)


class Line:
    """The line of the speeches of one voice, in the order in which they joined."""

    def __init__(self) -> None:
        self._turns: deque[Turn] = deque()

    def join(self) -> Turn:
        """Return a place behind all others.

        Raises:
            SoundBusy: `LONGEST_LINE` speeches wait already.
        """
        if len(self._turns) >= LONGEST_LINE:
            raise SoundBusy(f"{LONGEST_LINE} speeches wait already, which is the limit; wait until one has ended")
        turn = Turn(self)
        self._turns.append(turn)
        self.advance()
        return turn

    def advance(self) -> None:
        """Let the first speech that still needs a place have it."""
        while self._turns and self._turns[0].is_over:
            self._turns.popleft()
        if self._turns:
            self._turns[0].settle(True)
