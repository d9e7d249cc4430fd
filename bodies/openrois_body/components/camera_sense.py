"""The base of the senses of a camera, which share what sees persons in its pictures."""

from datetime import UTC, datetime
from typing import Protocol

from openrois.adapter import ComponentStatus
from openrois.aio.listeners import Listeners
from openrois_body.components.sensing import Sense
from openrois_body.sensing.activity import Activity
from openrois_body.vision.sighting import Sighting

__all__ = ["CameraSense", "SightingSource"]


class SightingSource(Protocol):
    """What sees persons: `openrois_body.vision.watch`, or a robot that detects them itself."""

    @property
    def seen(self) -> Listeners[Sighting]:
        """Called with all persons that are seen, again and again."""
        ...

    def problem(self) -> str:
        """Return why no persons can be seen now; empty where they can."""
        ...

    def serve(self, activity: Activity) -> None:
        """Look while `activity` is active."""
        ...

    def wall_at(self, moment: float) -> float:
        """Return the time of day, in seconds since the epoch, of the `moment` of a sighting."""
        ...


class CameraSense(Sense):
    """Mixin that makes a component a sense of the camera; it stands before the standard's base class.

    A subclass announces changes in `sense`, and forgets in `begin` what it announced before.

    Args:
        watch: sees persons.
    """

    def __init__(self, watch: SightingSource) -> None:
        super().__init__()
        self._watch = watch
        watch.serve(self.activity)
        watch.seen.add(self._on_seen)
        self.activity.changed.add(lambda works: self.begin() if works else None)

    def condition(self) -> ComponentStatus:
        """Return ERROR where no persons can be seen, else READY: of an operator, with a camera or without."""
        return ComponentStatus.ERROR if self._watch.problem() else ComponentStatus.READY

    def problem(self) -> str:
        """Return why no persons can be seen."""
        return self._watch.problem()

    def begin(self) -> None:
        """Forget what was announced: new subscribers have not received it."""

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce what has changed; `moment` is when the picture was taken."""
        raise NotImplementedError

    def _on_seen(self, seen: Sighting) -> None:
        if self.activity.works:
            self.visitor_ref = seen.visitor_ref
            self.sense(seen, datetime.fromtimestamp(self._watch.wall_at(seen.moment), UTC))
