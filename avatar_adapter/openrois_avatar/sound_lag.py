"""How long the avatar's sound waits for a game engine that sends its own too late. Pure."""

from typing import Final

LONGEST: Final = 0.25
"""Seconds; an engine's sound that is later than that is not waited for."""
REMEMBERED: Final = 2.0
"""Seconds for which the latest sound is remembered at least; twice as long at most."""
MARGIN: Final = 0.003
"""Seconds by which the latest one may be exceeded before something is lost."""

_NEVER: Final = float("-inf")


class SoundLag:
    """Follows how late pieces of sound come; 0 for an engine that sends them ahead of their time.

    `seconds` after the moment of its first sample a block is given out. Its timestamp stays what it was: who shows
    pictures with the sound waits as long.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._latest = self._before = _NEVER
        self._since = _NEVER

    def arrived(self, late: float, now: float) -> None:
        """Sound came at `now`, `late` seconds after the moment of the block it belongs in; before it if negative."""
        if now - self._since >= REMEMBERED:
            gone = now - self._since >= 2 * REMEMBERED
            self._before = _NEVER if gone else self._latest
            self._latest, self._since = _NEVER, now
        self._latest = max(self._latest, late)
        self.seconds = min(max(0.0, max(self._latest, self._before) + MARGIN), LONGEST)
