"""How much later than it sounds the avatar is heard by those who listen: the way to them, and their buffers."""

from collections.abc import Iterable
from typing import Final

from openrois_streaming.errors import UnknownStream
from openrois_streaming.session.session import StreamSession
from openrois_streaming.state import StreamStatus
from openrois_streaming.stats import StreamStats

__all__ = ["DEVICE", "LONGEST", "PLAYOUT", "Audience", "way"]

PLAYOUT: Final = 0.2
"""Seconds from the arrival of a packet to its sound in a viewer's ear: buffer, decoder, device.

An estimate for a path without jitter and a viewer that does not say; `docs/avatar.md` has what was measured."""
DEVICE: Final = 0.05
"""Seconds from the end of a viewer's buffer, as far as it reports it, to the ear: decoder, mixer, device."""
JITTERS: Final = 3.0
"""How many times the reported jitter a viewer's buffer grows with it."""
LONGEST: Final = 1.0
"""Seconds; a viewer that is farther away, or says so, is not waited for."""


def way(round_trip_time: float | None, jitter: float | None, playout: float | None = None) -> float:
    """Seconds from the sending of a sound to its being heard, from what a viewer reports.

    Args:
        round_trip_time: seconds; None before its first report.
        jitter: seconds.
        playout: seconds from the arrival of a packet to its being played, where it says so itself.
    """
    buffer = PLAYOUT + JITTERS * (jitter or 0.0) if playout is None else playout + DEVICE
    return min((round_trip_time or 0.0) / 2 + buffer, LONGEST)


class Audience:
    """The viewers that hear the avatar now. Nobody does until `gather` has said where they are."""

    def __init__(self) -> None:
        self._sessions: Iterable[StreamSession] = ()
        self._component_ref = ""

    def gather(self, sessions: Iterable[StreamSession], component_ref: str) -> None:
        """Count those who play the sound of a component from now on; `sessions` is asked anew each time."""
        self._sessions, self._component_ref = sessions, component_ref

    async def lateness(self) -> float:
        """Seconds from the sending of a sound until the last of them has heard it; without any, a near one would."""
        listening = await self._listening()
        ways = [way(stream.round_trip_time, stream.jitter, stream.playout_delay) for stream in listening]
        return max(ways, default=way(None, None))

    async def _listening(self) -> list[StreamStats]:
        found = []
        for session in self._sessions:
            for stream_id in session.stream_ids:
                try:
                    stream = await session.stats(stream_id)
                except UnknownStream:  # it ended while the others were asked
                    continue
                if stream.component_ref == self._component_ref and stream.status is StreamStatus.RUNNING:
                    found.append(stream)
        return found
