"""An event loop in which time passes only when nothing is left to do: hours of a simulation take no time."""

import asyncio
import selectors
from typing import Any

__all__ = ["JumpingLoop"]


class _Jumping(selectors.DefaultSelector):
    """A selector that does not wait: it tells how long it would have."""

    def __init__(self) -> None:
        super().__init__()
        self.passed = 0.0

    def select(self, timeout: float | None = None) -> list[Any]:
        ready = super().select(0)
        if not ready:
            if timeout is None:
                raise RuntimeError("every task waits, and no timer runs that would wake one")
            self.passed += timeout
        return ready


class JumpingLoop(asyncio.SelectorEventLoop):
    """Begins at 0 s, and jumps to the next timer. What waits for a thread or a socket must not run in it."""

    def __init__(self) -> None:
        self._jumping = _Jumping()
        super().__init__(self._jumping)

    def time(self) -> float:
        """Return the seconds since the loop was made."""
        return self._jumping.passed
