"""What can be exchanged for something better: who finds faces, and who tells them apart; found by entry points."""

from collections.abc import Sequence
from typing import Final, Protocol

from openrois_avatar.backends import Backend
from openrois_avatar.vision.box import Face
from openrois_avatar.vision.gallery import Likeness
from openrois_avatar.vision.view import View

__all__ = ["FINDERS", "RECOGNIZERS", "FaceFinder", "FaceRecognizer"]

FINDERS: Final = "openrois.face_finders"
RECOGNIZERS: Final = "openrois.face_recognizers"
"""The groups of entry points. Each is called without arguments and returns a backend."""


class FaceFinder(Backend, Protocol):
    """Finds faces in pictures. It is called in a thread of its own, with one picture after the other of one camera."""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        """Return all faces in the picture, also those that are known.

        Args:
            view: the picture.
            known: where faces are that are followed already, moved with the picture: a finder may look there first,
                and only now and then everywhere.
        """
        ...


class FaceRecognizer(Backend, Protocol):
    """Makes vectors of faces: the nearer two are (Euclidean distance), the more alike are the faces."""

    limit: float
    """The distance from which on two vectors are of different persons."""

    def likeness(self, view: View, face: Face) -> Likeness | None:
        """Return the vector of a face, or None where it is too small or too blurred to tell."""
        ...
