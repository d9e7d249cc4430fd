"""A clock that tests turn by hand."""

from dataclasses import dataclass


@dataclass
class Clock:
    """Seconds, monotonic or since the epoch."""

    now: float = 0.0

    def __call__(self) -> float:
        return self.now
