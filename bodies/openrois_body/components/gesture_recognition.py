"""GestureRecognition (component 10) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_body.components.camera_sense import CameraSense
from openrois_body.vision.sighting import Sighting
from openrois_body.vision.watch import Watch

__all__ = ["GestureRecognition"]


class GestureRecognition(CameraSense, components.GestureRecognition):
    """Announces the gestures of persons in front of the camera, as far as the reader knows them.

    Args:
        watch: analyses the camera's pictures.
        gestures: the refs of the gestures that the reader knows.
    """

    def __init__(self, watch: Watch, gestures: tuple[str, ...]) -> None:
        super().__init__(watch)
        self.recognizable_gestures = gestures

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce the gestures that this picture completes."""
        made = tuple(person.gesture for person in seen.persons if person.gesture is not None)
        if made:
            self.gesture_recognized(made, moment)
