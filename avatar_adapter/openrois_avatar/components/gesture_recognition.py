"""GestureRecognition (component 10) on the operator's camera: what heads do, by the identifiers of Annex D."""

from datetime import datetime
from typing import Final

from openrois.adapter import components
from openrois_avatar.components.camera_sense import CameraSense
from openrois_avatar.vision.head_gestures import Gesture
from openrois_avatar.vision.seen import Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["GESTURE_REFS", "GestureRecognition"]

GESTURE_REFS: Final[dict[Gesture, str]] = {
    "nod": "urn:x-rois:def:gesture:OMG::1",
    "tilt": "urn:x-rois:def:gesture:OMG::2",
    "shake_head": "urn:x-rois:def:gesture:OMG::3",
}
"""The refs of the gestures: their numbers in Annex D, which is informative."""


class GestureRecognition(CameraSense, components.GestureRecognition):
    """Tells when somebody nods, shakes the head or tilts it; hands are not looked at.

    Args:
        watch: what looks at the camera.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__("GestureRecognition", watch)
        self.recognizable_gestures = tuple(GESTURE_REFS.values())

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell the gestures that this picture completes."""
        made = tuple(GESTURE_REFS[person.gesture] for person in seen.persons if person.gesture is not None)
        if made:
            self.gesture_recognized(made, moment)
