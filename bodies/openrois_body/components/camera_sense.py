"""The base of the senses of the operator's camera, which share one watch."""

from datetime import UTC, datetime

from openrois.adapter import ComponentStatus
from openrois_body.components.sensing import Sense
from openrois_body.vision.sighting import Sighting
from openrois_body.vision.watch import Watch

__all__ = ["CameraSense"]


class CameraSense(Sense):
    """Mixin that makes a component a sense of the camera; it stands before the standard's base class.

    A subclass announces changes in `sense`, and forgets in `begin` what it announced before.

    Args:
        watch: analyses the camera's pictures.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch
        watch.serve(self.activity)
        watch.seen.add(self._on_seen)
        self.activity.changed.add(lambda works: self.begin() if works else None)

    def condition(self) -> ComponentStatus:
        """Return ERROR where pictures cannot be analysed, else READY, with a camera or without."""
        return ComponentStatus.ERROR if self._watch.failure else ComponentStatus.READY

    def begin(self) -> None:
        """Forget what was announced: new subscribers have not received it."""

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce what has changed; `moment` is when the picture was taken."""
        raise NotImplementedError

    def _on_seen(self, seen: Sighting) -> None:
        if self.activity.works:
            self.sense(seen, datetime.fromtimestamp(self._watch.wall_at(seen.moment), UTC))
