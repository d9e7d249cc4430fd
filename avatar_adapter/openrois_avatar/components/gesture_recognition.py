"""GestureRecognition (component 10) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_avatar.components.camera_sense import CameraSense
from openrois_avatar.vision.seen import Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["GestureRecognition"]


class GestureRecognition(CameraSense, components.GestureRecognition):
    """Tells the gestures that somebody makes, of those that its reader knows.

    Args:
        watch: what looks at the camera.
        gestures: the refs of those that can be told.
    """

    def __init__(self, watch: Watch, gestures: tuple[str, ...]) -> None:
        super().__init__(watch)
        self.recognizable_gestures = gestures

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell the gestures that this picture completes."""
        made = tuple(person.gesture for person in seen.persons if person.gesture is not None)
        if made:
            self.gesture_recognized(made, moment)
