"""Sight: faces as an overlay of the operator's camera picture. A component of OpenRoIS."""

from datetime import datetime

from openrois.adapter import Component, event
from openrois_body.components.camera_sense import CameraSense
from openrois_body.vision.box import Box
from openrois_body.vision.sighting import Refs, Sighting
from openrois_body.vision.watch import Watch

__all__ = ["Sight"]


class Sight(CameraSense, Component, authority="OpenRoIS", function="sensing"):
    """Announces where in the picture the faces are, and their names, ten times a second at most.

    Args:
        watch: analyses the camera's pictures.
        refs: makes the refs of persons.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs
        self._is_empty = True

    def begin(self) -> None:
        """Forget the faces that were announced."""
        self._is_empty = True

    def sense(self, seen: Sighting, moment: datetime) -> None:
        """Announce all faces, and once that there is none."""
        shown = [person for person in seen.persons if person.face]
        if shown or not self._is_empty:
            self.seen(
                tuple(self._refs.person(person) for person in shown),
                tuple(_text(person.box) for person in shown),
                tuple(person.name or "" for person in shown),
                tuple(person.gesture or "" for person in shown),
                moment,
                seen.visitor_ref or None,
            )
        self._is_empty = not shown

    @event
    def seen(
        self,
        person_ref: tuple[str, ...],
        box: tuple[str, ...],
        name: tuple[str, ...],
        gesture_ref: tuple[str, ...],
        timestamp: datetime,
        visitor_ref: str | None = None,
    ) -> None:
        """The faces in a picture: whose, where (`left,top,width,height` in shares of it), name, gesture.

        `visitor_ref` is whose camera it is, where visitors are told apart.
        """


def _text(box: Box) -> str:
    return ",".join(f"{share:.4f}" for share in box)
