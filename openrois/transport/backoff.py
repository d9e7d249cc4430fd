"""Delays before further attempts. Pure."""

import re
from typing import Final

__all__ = ["Backoff", "asked_to_wait"]

_RETRY_AFTER: Final = re.compile(r"retry_after=(\d{1,4}(?:\.\d{1,6})?)(?: .*)?", re.ASCII | re.DOTALL)


class Backoff:
    """Delays that grow from `first` by `factor` up to `limit`; they start over after something that lasted.

    Args:
        first: the first delay, seconds.
        factor: by how much each delay is longer than the one before.
        limit: the longest delay, seconds.
        lasting: seconds after which an attempt counts as a success.
    """

    def __init__(self, first: float = 1.0, factor: float = 1.5, limit: float = 30.0, lasting: float = 10.0) -> None:
        self._first = first
        self._factor = factor
        self._limit = limit
        self._lasting = lasting
        self._next = first

    def after(self, lasted: float) -> float:
        """Return the delay after an attempt that lasted `lasted` seconds."""
        if lasted >= self._lasting:
            self._next = self._first
        delay, self._next = self._next, min(self._next * self._factor, self._limit)
        return delay


def asked_to_wait(reason: str) -> float:
    """Return the seconds that a gateway asks for when it closes because it restarts, or cannot serve now; else 0.

    Args:
        reason: of its close frame; such a gateway says `retry_after=<seconds>`, and maybe why behind a space.
    """
    asked = _RETRY_AFTER.fullmatch(reason)
    return float(asked[1]) if asked else 0.0
