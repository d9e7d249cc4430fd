"""What can be exchanged for something better: what finds faces, tells them apart, and reads gestures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from openrois_avatar.backends import Backend
from openrois_avatar.vision.box import Face, Motion
from openrois_avatar.vision.gallery import Likeness
from openrois_avatar.vision.view import View

__all__ = ["FINDERS", "GESTURE_READERS", "RECOGNIZERS", "FaceFinder", "FaceRecognizer", "Followed", "GestureReader"]

FINDERS: Final = "openrois.face_finders"
RECOGNIZERS: Final = "openrois.face_recognizers"
GESTURE_READERS: Final = "openrois.gesture_readers"
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


@dataclass(frozen=True, slots=True)
class Followed:
    """Somebody who is followed: who, where the face is, and how it moved since the last picture, if that is known.

    `motion` is in shares of the picture, as the box is; `number` is nobody else's.
    """

    number: int
    face: Face
    motion: Motion | None


class GestureReader(Backend, Protocol):
    """Reads gestures of those who are followed, from one picture after the other, in the thread of the finder."""

    gestures: tuple[str, ...]
    """The refs of all gestures that it knows."""

    def read(self, view: View, persons: Sequence[Followed]) -> Mapping[int, str]:
        """Return the gestures that the picture completes: refs, by the numbers of the persons.

        Args:
            view: the picture.
            persons: all who are followed; whoever is no longer among them does not come back.
        """
        ...
