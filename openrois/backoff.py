"""How long to wait before trying again."""

__all__ = ["Backoff"]


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
