"""The demand for an engine's pictures: the engine draws nothing while there is none."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from openrois_streaming.clock import MediaClock

from openrois_avatar.link.messages import Command, Demand, LinkError

_log = logging.getLogger(__name__)


class PictureDemand:
    """Counts the consumers of the connected engine's pictures, and sends the number to an engine that takes `demand`.

    Attributes:
        consumers: the number of consumers. The encoders are one consumer, however many viewers they serve.
        since: when the present demand began, in seconds of the media clock.
    """

    def __init__(self, clock: MediaClock) -> None:
        self.consumers = 0
        self.since = float("-inf")
        self._clock = clock
        self._ask: Callable[[Command], None] | None = None

    @property
    def sleeping(self) -> bool:
        """Whether the connected engine has to draw nothing now."""
        return self._ask is not None and self.consumers == 0

    def engine_arrived(self, ask: Callable[[Command], None]) -> None:
        """Note an engine that takes `demand`; `ask` sends it a command."""
        self._ask = ask
        self._send_demand()

    def engine_gone(self) -> None:
        """Note that the engine is disconnected."""
        self._ask = None

    @contextmanager
    def wanted(self) -> Iterator[None]:
        """Count a consumer while the context lasts."""
        if self.consumers == 0:
            self.since = self._clock.now()
        self.consumers += 1
        self._send_demand()
        try:
            yield
        finally:
            self.consumers -= 1
            self._send_demand()

    def is_stale(self, captured_at: float) -> bool:
        """Return whether a picture was drawn before the present demand began, by an engine that sleeps until then.

        Such a picture was on its way when the engine was sent to sleep; other engines draw all the time.
        """
        return self._ask is not None and captured_at < self.since

    def _send_demand(self) -> None:
        if self._ask is None:
            return
        try:
            self._ask(Demand(self.consumers))
        except LinkError as error:
            _log.debug("the demand was not sent to the game engine: %s", error)
