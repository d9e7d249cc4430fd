"""FaceDetection and FaceLocalization (components 5 and 6) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_avatar.components.camera_sense import CameraSense
from openrois_avatar.components.sensing import Localizing
from openrois_avatar.sensing.changes import Numbers
from openrois_avatar.vision.seen import Refs, Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["FaceDetection", "FaceLocalization"]


class FaceDetection(CameraSense, components.FaceDetection):
    """Tells how many faces look at the camera, when that changes.

    Args:
        watch: what looks at the camera.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__(watch)
        self._numbers = Numbers()

    def begin(self) -> None:
        """Tell the number again, and 0 where it was another one."""
        self._numbers.begin()

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell another number of faces."""
        number = sum(person.face for person in seen.persons)
        if self._numbers.tells(number):
            self.face_detected(number, moment)


class FaceLocalization(CameraSense, Localizing, components.FaceLocalization):
    """Tells where the faces are that look at the camera: an estimate from their size in the picture.

    Args:
        watch: what looks at the camera.
        refs: how faces are called.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs

    def begin(self) -> None:
        """Begin with nobody."""
        self.forget_places()

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell movements that are far enough."""
        places = {self._refs.face(person): person.place for person in seen.persons if person.face}
        if self.tells(places, seen.moment):
            self.face_localized(tuple(places), tuple(place.text for place in places.values()), moment)
