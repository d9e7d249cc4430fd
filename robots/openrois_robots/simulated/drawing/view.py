"""What a camera sees at a moment: where it is, and who has moved. Pure."""

from dataclasses import dataclass

from openrois_body.messages import Place

__all__ = ["View"]


@dataclass(frozen=True, slots=True)
class View:
    """A view of the rooms.

    Attributes:
        camera: over which place of the floor the camera is, and where it looks.
        tilt: by how many radians it looks up.
        visitor: where the walking visitor is; None without one.
        step: metres that the visitor has walked.
    """

    camera: Place
    tilt: float = 0.0
    visitor: Place | None = None
    step: float = 0.0
