"""Health of the video and audio sources: a RoIS component status, and faults to report. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois_streaming.source.supervision import HUNG, Pace, SourceWatch

from openrois.types.codes import ComponentStatus, ErrorType

__all__ = ["GRAVITY", "Health", "Observed", "Trouble", "worst"]

_STATUS: Final = {
    Pace.WELL: ComponentStatus.READY,
    Pace.QUIET: ComponentStatus.WARNING,
    Pace.HUNG: ComponentStatus.ERROR,
}

GRAVITY: Final = (ComponentStatus.READY, ComponentStatus.WARNING, ComponentStatus.ERROR)
"""Statuses of a source, from well to worst."""


@dataclass(frozen=True, slots=True)
class Observed:
    """Observation of a source.

    Attributes:
        last_frame_at: time of its last frame, in seconds of the media clock.
        frames: number of frames so far.
        wanted: whether it should give frames.
        failure: a sentence on why there are none, if that is known.
        unseen: whether its state is unknown, because no viewer plays it.
    """

    last_frame_at: float | None
    frames: int = 0
    wanted: bool = True
    failure: str = ""
    unseen: bool = False


@dataclass(frozen=True, slots=True)
class Trouble:
    """Fault to be reported: its kind, and a sentence for a person."""

    error_type: ErrorType
    description: str


class Health:
    """Health of one source. It is to be judged every `CHECK_INTERVAL` of `openrois_streaming.source.supervision`.

    A source without frames for a second is in WARNING; without for five seconds, or with a known failure, in ERROR. It
    is READY with its next frame, and while no frame is wanted or overdue.

    ERROR is reported once until the source recovers: with a frame or, if its state is known without any, once none is
    wanted and it has not failed.

    Args:
        what: its name in sentences, as in "the picture".
        now: seconds of the media clock.
    """

    def __init__(self, what: str, now: float) -> None:
        self.status = ComponentStatus.READY
        self.what = what
        self.missed = False
        """Whether it was in WARNING or ERROR and has not recovered."""
        self._watch = SourceWatch(now)
        self._missed_at = now
        self._reported = False

    def judge(self, now: float, observed: Observed) -> Trouble | None:
        """Judge an observation; returns a new fault to be reported, if there is one."""
        pace = self._watch.judge(now, observed.last_frame_at, wanted=observed.wanted and not observed.failure)
        self.status = ComponentStatus.ERROR if observed.failure else _STATUS[pace]
        if self.status is not ComponentStatus.READY:
            self.missed, self._missed_at = True, now
        elif self._is_there(observed):
            self.missed = self._reported = False
        if self.status is not ComponentStatus.ERROR or self._reported:
            return None
        self._reported = True
        if observed.failure:
            return Trouble(ErrorType.COMPONENT_INTERNAL_ERROR, observed.failure)
        return Trouble(ErrorType.COMPONENT_NOT_RESPONDING, f"{self.what} has given no frame for {HUNG:.0f} s")

    def _is_there(self, observed: Observed) -> bool:
        if not observed.wanted:
            return not observed.unseen
        return observed.last_frame_at is not None and observed.last_frame_at >= self._missed_at


def worst(*statuses: ComponentStatus) -> ComponentStatus:
    """Return the gravest of READY, WARNING and ERROR."""
    return max(statuses, key=GRAVITY.index)
