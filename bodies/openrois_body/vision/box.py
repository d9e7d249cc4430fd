"""Faces in a picture, in shares of its size, and their places in the room. Pure."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

from openrois_body.sensing.changes import Place

__all__ = ["FACE_WIDTH", "FIELD_OF_VIEW", "Box", "Face", "Motion", "place_of", "place_on_floor"]

FIELD_OF_VIEW: Final = math.radians(60)
"""Assumed field of view of the longer side of a camera's picture; webcams and telephones have 55 to 75 degrees."""
FACE_WIDTH: Final = 0.15
"""Width in metres of an adult face's box, measured on the boxes of the offline finder."""


class Box(NamedTuple):
    """A rectangle in a picture: shares of its width and height, from the left and from the top."""

    left: float
    top: float
    width: float
    height: float

    @property
    def centre(self) -> tuple[float, float]:
        """The middle of the box."""
        return self.left + self.width / 2, self.top + self.height / 2

    def overlap(self, other: "Box") -> float:
        """Return the intersection over union of both boxes."""
        wide = min(self.left + self.width, other.left + other.width) - max(self.left, other.left)
        high = min(self.top + self.height, other.top + other.height) - max(self.top, other.top)
        common = max(0.0, wide) * max(0.0, high)
        return common / (self.width * self.height + other.width * other.height - common) if common else 0.0

    def between(self, other: "Box", share: float) -> "Box":
        """Return the box that is `share` of the way to another one: 0 is this one, 1 the other."""
        return Box(*(mine + (its - mine) * share for mine, its in zip(self, other, strict=True)))


class Motion(NamedTuple):
    """The motion of a face from one picture to the next: `x` and `y` in shares of the picture, `roll` as in `Face`."""

    x: float
    y: float
    scale: float
    roll: float


@dataclass(frozen=True, slots=True)
class Face:
    """A face in a picture.

    `roll` is how far it leans in the picture, in radians, clockwise as the picture is seen; 0 is upright. The box is
    that of the face set upright around its middle.
    """

    box: Box
    roll: float = 0.0

    def moved(self, motion: Motion) -> "Face":
        """Return the face after a motion."""
        x, y = self.box.centre
        width, height = self.box.width * motion.scale, self.box.height * motion.scale
        box = Box(x + motion.x - width / 2, y + motion.y - height / 2, width, height)
        return Face(box, self.roll + motion.roll)


def place_of(box: Box, aspect: float) -> Place:
    """Estimate the place of a face: the camera is at the origin and looks along y, x is to the right in the picture.

    A pinhole camera with `FIELD_OF_VIEW` sees a face of `FACE_WIDTH`; `th` is the direction from the face to the
    camera, as if it looked there. Off by as much as camera and head differ from what is assumed, easily by a fifth.

    Args:
        box: of the face.
        aspect: the picture's width over its height.
    """
    wide = 2 * math.tan(FIELD_OF_VIEW / 2) * min(1.0, aspect)
    ahead = FACE_WIDTH / (box.width * wide)
    right = (box.centre[0] - 0.5) * wide * ahead
    return Place(right, ahead, math.atan2(-ahead, -right))


def place_on_floor(seen: Place, camera: Place, tilt: float = 0.0) -> Place:
    """Return where on the floor something is that a camera sees at about its own height.

    Args:
        seen: in the axes of the camera, as `place_of` returns it.
        camera: over which place of the floor the camera is; `th` is where it looks.
        tilt: radians by which it looks up.
    """
    ahead = seen.y / math.cos(tilt)
    along, across = math.cos(camera.th), math.sin(camera.th)
    return Place(
        camera.x + ahead * along + seen.x * across,
        camera.y + ahead * across - seen.x * along,
        math.remainder(seen.th + camera.th - math.pi / 2, math.tau),
    )
