"""The offline gesture reader: gestures of heads, by the identifiers of Annex D."""

from collections.abc import Mapping, Sequence
from typing import Final

from openrois_body.vision.backends import Followed
from openrois_body.vision.head_gestures import Gesture, HeadGestures
from openrois_body.vision.view import View

__all__ = ["GESTURE_REFS", "HeadReader"]

GESTURE_REFS: Final[Mapping[Gesture, str]] = {
    "nod": "urn:x-rois:def:gesture:OMG::1",
    "tilt": "urn:x-rois:def:gesture:OMG::2",
    "shake_head": "urn:x-rois:def:gesture:OMG::3",
}
"""The numbers of Annex D, which is informative."""


class HeadReader:
    """Reads nods, tilts and shakes of the head from the motion of faces."""

    gestures: tuple[str, ...] = tuple(GESTURE_REFS.values())

    def __init__(self) -> None:
        self._heads: dict[int, HeadGestures] = {}

    def available(self) -> tuple[bool, str]:
        """Return that it always works."""
        return True, ""

    def read(self, view: View, persons: Sequence[Followed]) -> Mapping[int, str]:
        """Return the gestures that the picture completes."""
        self._heads = {each.number: self._heads.get(each.number) or HeadGestures() for each in persons}
        found: dict[int, str] = {}
        for each in persons:
            if each.motion is not None:
                x, y = each.motion.x / each.face.box.width, each.motion.y / each.face.box.height
                gesture = self._heads[each.number].add_motion(view.moment, x, y, each.motion.roll)
                if gesture is not None:
                    found[each.number] = GESTURE_REFS[gesture]
        return found
