"""How what the avatar shows and says fares, in the words of RoIS: a component status, and faults to report. Pure."""

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
"""What a source can be in, from well to worst."""


@dataclass(frozen=True, slots=True)
class Observed:
    """What is seen of a source now.

    Attributes:
        last_frame_at: when it gave its last frame, in seconds of the media clock.
        frames: it has given so far.
        wanted: whether it should give frames.
        failure: a sentence on why there are none, where that is known at once.
        unseen: whether nothing can be known of it now, not even a failure: nobody plays it.
    """

    last_frame_at: float | None
    frames: int = 0
    wanted: bool = True
    failure: str = ""
    unseen: bool = False


@dataclass(frozen=True, slots=True)
class Trouble:
    """A fault to be reported: of which kind, and a sentence for a person."""

    error_type: ErrorType
    description: str


class Health:
    """How one source fares. It is to be looked at every `LOOK_INTERVAL` of `openrois_streaming.source.supervision`.

    A source without frames for a second is in WARNING, one for five seconds, or one that says that it has failed, in
    ERROR. It is READY with its next frame, and for as long as none is wanted or none is missed yet.

    ERROR is reported once until it is back: with a frame or, where it shows how it fares without any, once none is
    wanted and it has not failed.

    Args:
        what: it is called in sentences, as in "the picture".
        now: seconds of the media clock.
    """

    def __init__(self, what: str, now: float) -> None:
        self.status = ComponentStatus.READY
        self.what = what
        self.missed = False
        """Whether it was in WARNING or ERROR and is not back yet."""
        self._watch = SourceWatch(now)
        self._missed_at = now
        self._reported = False

    def look(self, now: float, observed: Observed) -> Trouble | None:
        """Judge what is seen; returns what is to be reported, if that is new."""
        pace = self._watch.look(now, observed.last_frame_at, wanted=observed.wanted and not observed.failure)
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
        return Trouble(ErrorType.COMPONENT_NOT_RESPONDING, f"{self.what} has stood still for {HUNG:.0f} s")

    def _is_there(self, observed: Observed) -> bool:
        if not observed.wanted:
            return not observed.unseen
        return observed.last_frame_at is not None and observed.last_frame_at >= self._missed_at


def worst(*statuses: ComponentStatus) -> ComponentStatus:
    """The gravest of READY, WARNING and ERROR."""
    return max(statuses, key=GRAVITY.index)
