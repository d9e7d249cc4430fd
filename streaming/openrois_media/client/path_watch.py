"""Watch on the media path of a peer connection, by what arrives. Pure: the time is an argument.

Times are seconds of one monotonic clock.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

__all__ = ["FIRST_FRAME_WITHIN", "Flow", "PathWatch", "Verdict"]

FIRST_FRAME_WITHIN: Final = 10.0
"""Seconds until the first frame of a stream that is expected."""

_SILENCE_LIMIT: Final = 2.0
"""Seconds between two frames. An engine gives up a receiver that is silent for four."""

_DISCONNECTED_LIMIT: Final = 1.0
_LATE_AFTER: Final = 1.0

# Seconds until a restart is asked for again, at first and at most.
_FIRST_PATIENCE: Final = 5.0
_MAX_PATIENCE: Final = 30.0


@dataclass(frozen=True, slots=True)
class Flow:
    """A stream that the peer connection carries.

    Attributes:
        stream_id: its name.
        expected: whether media should be arriving now: wanted, not suspended, and the engine says that it sends or is
            about to.
        count: a number that grows while media arrives; 0 before the first.
    """

    stream_id: str
    expected: bool
    count: int


class Verdict(IntEnum):
    """Judgement of a path; the greatest one counts."""

    FINE = 0
    """All that is expected arrives."""
    WAITING = 1
    """Something is late, or a restart was asked for and has not come."""
    RESTART = 2
    """The engine is to be asked for a new peer connection."""


@dataclass(slots=True)
class _Progress:
    count: int
    at: float


class PathWatch:
    """Watch on one peer connection."""

    def __init__(self) -> None:
        self._progress: dict[str, _Progress] = {}
        self._disconnected_since: float | None = None
        self._quiet_until = float("-inf")
        self._patience = _FIRST_PATIENCE

    def observe(self, now: float, connection: str, flows: Sequence[Flow]) -> Verdict:
        """Return the verdict; to be called about once a second with all flows.

        Args:
            now: the time.
            connection: state of the connection (W3C's RTCPeerConnectionState).
            flows: the streams that the connection carries.
        """
        present = {flow.stream_id for flow in flows}
        self._progress = {name: each for name, each in self._progress.items() if name in present}
        verdict = max([self._judge_connection(now, connection), *(self._judge_flow(now, flow) for flow in flows)])
        if verdict is Verdict.FINE:
            self._patience = _FIRST_PATIENCE
        if verdict is not Verdict.RESTART:
            return verdict
        if now < self._quiet_until:
            return Verdict.WAITING
        self._quiet_until = now + self._patience
        self._patience = min(_MAX_PATIENCE, self._patience * 1.5)
        return Verdict.RESTART

    def _judge_connection(self, now: float, connection: str) -> Verdict:
        if connection in ("failed", "closed"):
            return Verdict.RESTART
        if connection != "disconnected":
            self._disconnected_since = None
            return Verdict.FINE
        if self._disconnected_since is None:
            self._disconnected_since = now
        return Verdict.RESTART if now - self._disconnected_since >= _DISCONNECTED_LIMIT else Verdict.WAITING

    def _judge_flow(self, now: float, flow: Flow) -> Verdict:
        progress = self._progress.get(flow.stream_id)
        if progress is None or not flow.expected or progress.count != flow.count:
            self._progress[flow.stream_id] = _Progress(flow.count, now)
            return Verdict.FINE
        silence = now - progress.at
        if silence >= (FIRST_FRAME_WITHIN if flow.count == 0 else _SILENCE_LIMIT):
            return Verdict.RESTART
        return Verdict.WAITING if silence >= _LATE_AFTER else Verdict.FINE
