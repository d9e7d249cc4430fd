"""What the senders of one viewer share."""

from dataclasses import dataclass
from typing import Self

from openrois_streaming.clock import MediaClock
from openrois_streaming.send.pacer import Pacer
from openrois_streaming.send.probe import Later

SILENCE = 30.0
"""Seconds without sound after which pictures need not be shown with it. Shorter, a pause between words would do."""


@dataclass(slots=True)
class Outlet:
    """The times and the pace of what leaves for one viewer.

    `wall_offset` is the time of day (epoch seconds) at which the media clock was 0, the same for all of a viewer: from
    it a viewer learns which picture belongs to which sound.
    """

    clock: MediaClock
    wall_offset: float
    pacer: Pacer
    sound_at: float = float("-inf")
    """When a packet of sound left last, on the media clock."""

    @classmethod
    def made(cls, clock: MediaClock, wall_offset: float, later: Later) -> Self:
        """An outlet with a pacer of its own; `later` is the event loop's `call_later`."""
        return cls(clock, wall_offset, Pacer(clock, later))

    def sounds(self, now: float) -> bool:
        """Whether there is sound that the pictures of now belong to."""
        return now - self.sound_at < SILENCE
