"""The interfaces of exchangeable backends: face finder, face recogniser and gesture reader."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from openrois_body.backends import Backend
from openrois_body.vision.box import Face, Motion
from openrois_body.vision.gallery import Likeness
from openrois_body.vision.view import View

__all__ = ["FINDERS", "GESTURE_READERS", "RECOGNIZERS", "FaceFinder", "FaceRecognizer", "Followed", "GestureReader"]

FINDERS: Final = "openrois.face_finders"
RECOGNIZERS: Final = "openrois.face_recognizers"
GESTURE_READERS: Final = "openrois.gesture_readers"
"""The groups of entry points. Each is called without arguments and returns a backend."""


class FaceFinder(Backend, Protocol):
    """Finds faces in pictures. It is called in a thread of its own, with one picture after the other of one camera."""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        """Return all faces in the picture, the known ones too.

        Args:
            view: the picture.
            known: the tracked faces, moved with the picture: a finder may look there first,
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


@dataclass(frozen=True, slots=True)
class Followed:
    """A tracked person: number, face, and the motion of the face since the last picture, if that is known.

    `motion` is in shares of the picture, as the box is; `number` is unique.
    """

    number: int
    face: Face
    motion: Motion | None


class GestureReader(Backend, Protocol):
    """Reads gestures of tracked persons, from one picture after the other, in the thread of the finder."""

    gestures: tuple[str, ...]
    """The refs of all gestures that it knows."""

    def read(self, view: View, persons: Sequence[Followed]) -> Mapping[int, str]:
        """Return the gestures that the picture completes: refs, by the numbers of the persons.

        Args:
            view: the picture.
            persons: all tracked persons; a number that is missing does not come back.
        """
        ...
