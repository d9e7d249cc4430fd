"""The persons in one picture, with their faces, places, names and gestures. Pure."""

from dataclasses import dataclass, field
from urllib.parse import quote

from openrois_body.sensing.changes import Place
from openrois_body.vision.box import Box
from openrois_body.vision.gallery import Likeness

__all__ = ["Person", "Refs", "Sighting"]


@dataclass(frozen=True, slots=True)
class Person:
    """A person in front of the camera.

    Attributes:
        number: the same as long as the person is tracked; unique.
        box: of the face, where it was last known.
        place: an estimate, in the axes of the camera, or on the floor where it is known where the camera is.
        face: whether the face is seen now; else the person has turned away.
        name: the enrolled name, if the person is recognised.
        gesture: the ref of the gesture that this picture completes.
        likeness: of the face, during an enrolment.
    """

    number: int
    box: Box
    place: Place
    face: bool = True
    name: str | None = None
    gesture: str | None = None
    likeness: Likeness | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Sighting:
    """All persons in one picture; `moment` is when it was taken, in seconds of the media clock.

    `visitor_ref` is whose camera it is; empty for the body's own, and where there is no picture.
    """

    moment: float
    persons: tuple[Person, ...] = ()
    visitor_ref: str = ""


class Refs:
    """The RoIS refs of persons and faces in front of the camera.

    Args:
        engine_id: leads each id.
    """

    def __init__(self, engine_id: str) -> None:
        self._engine_id = engine_id

    def person(self, person: Person) -> str:
        """Return the ref of a tracked person."""
        return self._ref("person", f"camera/{person.number}")

    def face(self, person: Person) -> str:
        """Return the ref of a person's face, with the same id, so that the two can be related."""
        return self._ref("face", f"camera/{person.number}")

    def known(self, name: str) -> str:
        """Return the ref of an enrolled person."""
        return self._ref("person", f"enrolled/{quote(name, safe='')}")

    def _ref(self, kind: str, rest: str) -> str:
        return f"urn:x-rois:def:{kind}:OpenRoIS::{self._engine_id}/{rest}"
