"""FaceDetection and FaceLocalization (components 5 and 6) on the operator's camera."""

from datetime import datetime

from openrois.adapter import components
from openrois_body.components.camera_sense import CameraSense
from openrois_body.components.sensing import Localizing
from openrois_body.sensing.changes import Numbers
from openrois_body.vision.sighting import Refs, Sighting
from openrois_body.vision.watch import Watch

__all__ = ["FaceDetection", "FaceLocalization"]


class FaceDetection(CameraSense, components.FaceDetection):
    """Announces how many faces look at the camera, when that changes.

    Args:
        watch: analyses the camera's pictures.
    """

    def __init__(self, watch: Watch) -> None:
        super().__init__(watch)
        self._numbers = Numbers()

    def begin(self) -> None:
        """Announce the number again, and 0 where it was another one."""
        self._numbers.begin()

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce a changed number of faces."""
        number = sum(person.face for person in seen.persons)
        if self._numbers.is_news(number):
            self.face_detected(number, moment)


class FaceLocalization(CameraSense, Localizing, components.FaceLocalization):
    """Announces where the faces are that look at the camera: an estimate from their size in the picture.

    Places are on the floor of the body where it is known where its camera is, else in the axes of the camera.

    Args:
        watch: analyses the camera's pictures.
        refs: makes the refs of faces.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs

    def begin(self) -> None:
        """Forget the faces that were announced."""
        self.forget_places()

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce movements beyond the threshold."""
        places = {self._refs.face(person): person.place for person in seen.persons if person.face}
        if self.is_news(places, seen.moment):
            self.face_localized(tuple(places), tuple(place.text for place in places.values()), moment)
