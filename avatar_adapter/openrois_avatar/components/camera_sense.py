"""What the senses of the operator's camera have in common: one watch that all of them share."""

from datetime import UTC, datetime

from openrois.adapter import ComponentStatus
from openrois_avatar.components.sensing import Sense
from openrois_avatar.vision.seen import Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["CameraSense"]


class CameraSense(Sense):
    """Makes a component a sense of the camera, where it stands before the standard's base class.

    A subclass says in `sense` what is worth telling of what is seen, and in `begin` forgets what it told before.

    Args:
        watch: what looks at the camera.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__()
        self._watch = watch
        watch.serve(self.activity)
        watch.seen.add(self._take)
        self.activity.changed.add(lambda works: self.begin() if works else None)

    def condition(self) -> ComponentStatus:
        """ERROR where nothing can be seen, else READY, with a camera or without."""
        return ComponentStatus.ERROR if self._watch.failure else ComponentStatus.READY

    def begin(self) -> None:
        """Forget what was told: whoever listens from now on has not heard it."""

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell what is worth telling; `moment` is when the picture was taken."""
        raise NotImplementedError

    def _take(self, seen: Seen) -> None:
        if self.activity.works:
            self.sense(seen, datetime.fromtimestamp(self._watch.wall_at(seen.moment), UTC))
