"""Sight: what is to be drawn over the picture of the operator's camera. A component of our own."""

from datetime import datetime

from openrois.adapter import Component, event
from openrois_avatar.components.camera_sense import CameraSense
from openrois_avatar.vision.box import Box
from openrois_avatar.vision.seen import Refs, Seen
from openrois_avatar.vision.watch import Watch

__all__ = ["Sight"]


class Sight(CameraSense, Component, authority="OpenRoIS", function="sensing"):
    """Tells where in the picture the faces are, and whose, ten times a second at most.

    Args:
        watch: what looks at the camera.
        refs: how persons are called.
    """

    def __init__(self, watch: Watch, refs: Refs) -> None:
        super().__init__(watch)
        self._refs = refs
        self._nobody = True

    def begin(self) -> None:
        """Begin with nobody."""
        self._nobody = True

    def sense(self, seen: Seen, moment: datetime) -> None:
        """Tell everybody who is there; and nobody, once."""
        shown = [person for person in seen.persons if person.face]
        if shown or not self._nobody:
            self.seen(
                tuple(self._refs.person(person) for person in shown),
                tuple(_text(person.box) for person in shown),
                tuple(person.name or "" for person in shown),
                tuple(person.gesture or "" for person in shown),
                moment,
            )
        self._nobody = not shown

    @event
    def seen(
        self,
        person_ref: tuple[str, ...],
        box: tuple[str, ...],
        name: tuple[str, ...],
        gesture_ref: tuple[str, ...],
        timestamp: datetime,
    ) -> None:
        """The faces in a picture: whose, where (`left,top,width,height` in shares of it), name, gesture."""


def _text(box: Box) -> str:
    return ",".join(f"{share:.4f}" for share in box)
