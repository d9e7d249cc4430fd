"""The heartbeat between a gateway and what moves: signs of life while they are wanted, and the loss of the line."""

import time
from collections.abc import Callable
from typing import Final

from openrois.aio.listeners import Listeners

__all__ = ["ALIVE", "INTERVAL", "WATCH", "Heartbeat"]

ALIVE: Final = "openrois.alive"
"""Notification of a gateway to its adapter: a sign of life. Without params."""

WATCH: Final = "openrois.watch"
"""Notification of an adapter to its gateway: it wants signs of life from now on, or not any more: `{wanted}`."""

INTERVAL: Final = 0.1
"""Seconds between two signs of life."""


class Heartbeat:
    """The adapter's end.

    Args:
        clock: monotonic seconds.

    Attributes:
        seen_at: when the last sign of life came, or was first waited for.
        on_cut: called with the reason when the connection to the gateway has ended.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.seen_at = clock()
        self.on_cut = Listeners[str]()
        self._clock = clock
        self._wanted = False
        self._ask: Callable[[bool], None] | None = None

    @property
    def is_alive(self) -> bool:
        """Whether there is a gateway that sends signs of life on demand."""
        return self._ask is not None

    def attach(self, ask: Callable[[bool], None]) -> None:
        """Use a gateway that sends signs of life; `ask` tells it whether they are wanted."""
        self._ask = ask
        if self._wanted:
            self.sign()
            ask(True)

    def want(self, wanted: bool) -> None:
        """Want signs of life from now on, or not any more."""
        if wanted is not self._wanted:
            self._wanted = wanted
            self.sign()
            if self._ask is not None:
                self._ask(wanted)

    def sign(self) -> None:
        """Note a sign of life."""
        self.seen_at = self._clock()

    def cut(self, reason: str) -> None:
        """Note that the connection to the gateway has ended."""
        self._ask = None
        self.on_cut.notify_all(reason)
