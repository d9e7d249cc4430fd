"""The figures that are baked, each from all of its pieces."""

from collections.abc import Callable, Mapping
from typing import Final

from openrois_avatar.engines.figure.baked import Name, Piece

from tools.sculpt import body, eyes, face, furniture, hands, legs, visitor
from tools.sculpt.hair import Hair
from tools.sculpt.head import depth_of_face


def avatar() -> list[Piece]:
    """Every piece of the avatar. What is likely to be in front comes first."""
    depth, hair = depth_of_face(), Hair()
    return [
        *hands.pieces(),
        hair.piece(),
        *eyes.pieces(depth),
        *face.pieces(depth, hair.shadow),
        *body.pieces(),
        *legs.pieces(),
    ]


FIGURES: Final[Mapping[Name, Callable[[], list[Piece]]]] = {
    "avatar": avatar,
    "visitor": visitor.pieces,
    "room": furniture.pieces,
}
