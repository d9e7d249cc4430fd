"""The delay from sending a sound to its playout at the viewers: network path and jitter buffer."""

from collections.abc import Iterable
from typing import Final

from openrois_streaming.errors import UnknownStream
from openrois_streaming.session.session import StreamSession
from openrois_streaming.state import StreamStatus
from openrois_streaming.stats import StreamStats

__all__ = ["DEVICE", "LONGEST", "PLAYOUT", "PlayoutDelay", "way"]

PLAYOUT: Final = 0.2
"""Seconds from the arrival of a packet to its playout: buffer, decoder, device.

An estimate for a path without jitter and a viewer that does not report it; measured in
`docs/explanation/performance.md`.
"""
DEVICE: Final = 0.05
"""Seconds from the end of a viewer's reported buffer to its playout: decoder, mixer, device."""
JITTERS: Final = 3.0
"""Growth of a viewer's buffer in multiples of the reported jitter."""
LONGEST: Final = 1.0
"""The longest delay in seconds; a viewer with a longer one is not waited for."""


def way(round_trip_time: float | None, jitter: float | None, playout: float | None = None) -> float:
    """Return the seconds from the sending of a sound to its playout, from the reports of a viewer.

    Args:
        round_trip_time: seconds; None before its first report.
        jitter: seconds.
        playout: seconds from the arrival of a packet to its playout, where the viewer reports that.
    """
    buffer = PLAYOUT + JITTERS * (jitter or 0.0) if playout is None else playout + DEVICE
    return min((round_trip_time or 0.0) / 2 + buffer, LONGEST)


class PlayoutDelay:
    """The playout delay of the viewers that play the body's sound; none before `observe_sessions`."""

    def __init__(self) -> None:
        self._sessions: Iterable[StreamSession] = ()
        self._component_ref = ""

    def observe_sessions(self, sessions: Iterable[StreamSession], component_ref: str) -> None:
        """Count the viewers that play the sound of a component, of `sessions` as they are at each call."""
        self._sessions, self._component_ref = sessions, component_ref

    async def lateness(self) -> float:
        """Return the longest delay of all viewers in seconds; without any, that of a near one."""
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
