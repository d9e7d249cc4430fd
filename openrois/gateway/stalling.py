"""Detects that the other side of a connection has stopped reading. Pure."""

from typing import Final

__all__ = ["STALL_TIMEOUT", "Stalling"]

STALL_TIMEOUT: Final = 10.0
"""Seconds for which a connection with unsent messages may take no byte."""


class Stalling:
    """Progress of the other side of one connection in reading.

    Args:
        timeout: seconds for which it may take nothing.

    Attributes:
        written: bytes that were handed to the transport.
    """

    def __init__(self, timeout: float = STALL_TIMEOUT) -> None:
        self._timeout = timeout
        self.written = 0
        self._taken = 0
        self._since: float | None = None

    def is_over(self, now: float, unsent: int) -> bool:
        """Tell whether nothing was taken for too long.

        Args:
            now: monotonic seconds.
            unsent: bytes that wait in front of the kernel.
        """
        taken = self.written - unsent
        if not unsent:
            self._since = None
        elif self._since is None or taken > self._taken:
            self._since, self._taken = now, taken
        return self._since is not None and now - self._since >= self._timeout
