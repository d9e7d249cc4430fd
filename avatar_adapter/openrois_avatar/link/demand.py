"""What wants an engine's pictures: the engine is told how many, and draws nothing while there are none."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from openrois_streaming.clock import MediaClock

from openrois_avatar.link.messages import Command, Demand, LinkError

_log = logging.getLogger(__name__)


class PictureDemand:
    """Counts the consumers of the pictures of whichever engine is connected, and tells an engine that wants to know.

    Attributes:
        consumers: how many want pictures now. The encoders are one consumer, however many viewers they serve.
        since: when pictures came to be wanted last, in seconds of the media clock.
    """

    def __init__(self, clock: MediaClock) -> None:
        self.consumers = 0
        self.since = float("-inf")
        self._clock = clock
        self._ask: Callable[[Command], None] | None = None

    @property
    def sleeping(self) -> bool:
        """Whether the connected engine is to draw nothing now."""
        return self._ask is not None and self.consumers == 0

    def begin(self, ask: Callable[[Command], None]) -> None:
        """An engine has come that honours the demand; `ask` sends it a command."""
        self._ask = ask
        self._tell()

    def end(self) -> None:
        """The engine has gone."""
        self._ask = None

    @contextmanager
    def wanted(self) -> Iterator[None]:
        """Want pictures while the context lasts."""
        if self.consumers == 0:
            self.since = self._clock.now()
        self.consumers += 1
        self._tell()
        try:
            yield
        finally:
            self.consumers -= 1
            self._tell()

    def is_stale(self, captured_at: float) -> bool:
        """Whether a picture was drawn before pictures came to be wanted, by an engine that sleeps until then.

        Such a picture was on its way when the engine was told to stop; other engines draw all the time.
        """
        return self._ask is not None and captured_at < self.since

    def _tell(self) -> None:
        if self._ask is None:
            return
        try:
            self._ask(Demand(self.consumers))
        except LinkError as error:
            _log.debug("not told to the game engine: %s", error)
