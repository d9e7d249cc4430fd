"""What is seen in one picture: persons with their faces, places, names and gestures."""

from dataclasses import dataclass, field
from urllib.parse import quote

from openrois_avatar.sensing.changes import Place
from openrois_avatar.vision.box import Box
from openrois_avatar.vision.gallery import Likeness

__all__ = ["Person", "Refs", "Seen"]


@dataclass(frozen=True, slots=True)
class Person:
    """Somebody in front of the camera.

    Attributes:
        number: the same as long as the person is followed; nobody else gets it.
        box: of the face, where it was last known.
        place: an estimate.
        face: whether the face is seen now; else the person has turned away.
        name: who it is, if that is known.
        gesture: the ref of what this picture completes.
        likeness: what the face looks like, where somebody wants to know.
    """

    number: int
    box: Box
    place: Place
    face: bool = True
    name: str | None = None
    gesture: str | None = None
    likeness: Likeness | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Seen:
    """Everybody in one picture; `moment` is when it was taken, in seconds of the media clock."""

    moment: float
    persons: tuple[Person, ...] = ()


class Refs:
    """How persons and faces in front of the camera are called in RoIS.

    Args:
        engine_id: leads each id.
    """

    def __init__(self, engine_id: str) -> None:
        self._engine_id = engine_id

    def person(self, person: Person) -> str:
        """Return the ref of somebody who is followed."""
        return self._ref("person", f"camera/{person.number}")

    def face(self, person: Person) -> str:
        """Return the ref of their face: the same id as the person's, so that the two can be related."""
        return self._ref("face", f"camera/{person.number}")

    def known(self, name: str) -> str:
        """Return the ref of somebody who is enrolled."""
        return self._ref("person", f"enrolled/{quote(name, safe='')}")

    def _ref(self, kind: str, rest: str) -> str:
        return f"urn:x-rois:def:{kind}:OpenRoIS::{self._engine_id}/{rest}"
