"""The motion of the mouth: lips that deform, teeth, tongue and the dark behind them.

The lips are a grid (rings, spokes, 3) around the line where they meet; spokes run from the avatar's left corner over
the upper lip to the right corner and back along the lower lip. Rings run from inside the mouth to the cheek.
"""

from collections.abc import Callable

import numpy as np

from openrois_avatar.engines.animation.pose import Mouth, Pose
from openrois_avatar.engines.figure.head import JAW_ANGLE, jaw_turned, patched
from openrois_avatar.engines.figure.mesh import Array, smooth
from openrois_avatar.engines.figure.part import Motion, Shape, State, stepped

SPOKES = 60
TONGUE_LIFT = (0.0, -0.17, 0.090)
"""Where the tongue goes (dm) when it is raised fully."""
TEETH_HIDE = (0.0, 0.10, 0.030)
"""Where the upper teeth go (dm), seen from the lips, when these are rounded fully."""
INSIDE = 3
"""Number of rings behind the lips."""
BORDER = INSIDE + 5
"""The ring where the red of the lips ends."""
RINGS = INSIDE + 13

_ANGLE = np.arange(SPOKES) * 2 * np.pi / SPOKES
ACROSS, HEIGHT = np.cos(_ANGLE), np.sin(_ANGLE)
UPPER = HEIGHT > 1e-6
"""Which spokes go over the upper lip."""
MIDDLE = np.clip(1 - ACROSS**2, 0, 1)
_RING = np.arange(RINGS)
NEAR_LIP = (1 - smooth((_RING - BORDER - 1) / (RINGS - BORDER - 2)))[:, None]
"""Share by which each ring follows the lips, (RINGS, 1) 0..1."""
_RED = np.clip(1 - np.abs(_RING - INSIDE - 2.0) / 4.0, 0, 1)[:, None]
# Beside the corners the skin folds when they rise: it is lit as the face is, or it shows dark patches.
_SMOOTHED = smooth((_RING - BORDER) / 2)[:, None] * smooth((np.abs(ACROSS) - 0.45) / 0.35)
"""Share by which the skin around the lips is lit as the face under it, (RINGS, SPOKES) 0..1."""


class Lips:
    """The lips and the skin around them, deformed by a mouth shape."""

    def __init__(self, rest: Array, jaw: Array) -> None:
        """Take the vertices at rest (RINGS, SPOKES, 3), and how far each follows the jaw (RINGS, SPOKES)."""
        self._rest, self._jaw = rest, jaw

    def grid(self, mouth: Mouth) -> Array:
        """Vertices (RINGS, SPOKES, 3) in head space."""
        near, grid = NEAR_LIP, self._rest.copy()
        x, y, z = grid[:, :, 0], grid[:, :, 1], grid[:, :, 2]
        narrow = 1 - 0.42 * mouth.round * near
        spread = (0.085 * mouth.wide + 0.045 * mouth.smile) * near
        corner = np.abs(ACROSS) ** 1.5
        away = np.where(UPPER, 1.0, -1.0)
        # A narrow mouth opens evenly, a wide one most in the middle.
        arch = MIDDLE ** (0.6 - 0.25 * mouth.round)
        z += near * (
            np.where(UPPER, mouth.upper * 0.055, -mouth.lower * 0.060) * arch + mouth.smile * 0.062 * corner**2
        )
        # Lips that push forward turn their red outwards, at the corners too; pressed lips roll it inwards.
        rolled = mouth.round * (0.034 - 0.020 * arch) - mouth.press * 0.034 * arch - mouth.wide * 0.010 * arch
        z += away * _RED * rolled
        y += near * (-0.105 * mouth.round * (0.4 + 0.6 * arch) + 0.05 * (mouth.wide + mouth.smile) * corner)
        y += _RED * arch * 0.045 * mouth.press
        x += np.sign(ACROSS) * corner * 0.03 * mouth.press * near
        tuck = mouth.bite * arch * np.where(UPPER, 0.0, 1.0)
        z += _RED * tuck * 0.060
        y += _RED * tuck * 0.070
        x[...] = x * narrow + np.sign(ACROSS) * corner * spread
        return jaw_turned(grid, self._jaw, JAW_ANGLE * mouth.jaw)


def cavity(rim: Array) -> Array:
    """The dark bowl behind the lips (5, n, 3): it begins where their innermost ring, (n, 3), ends."""
    middle = rim.mean(axis=0)
    rows = []
    for size, depth in ((1.0, 0.0), (1.06, 0.08), (1.05, 0.18), (0.7, 0.27), (0.01, 0.30)):
        rows.append(middle + (rim - middle) * size + np.asarray((0.0, depth, 0.0)))
    return np.stack(rows)


def lips_motion(rest: Array, jaw: Array, skin_normals: Array) -> Motion:
    """Return the motion of the lips; `skin_normals` are of the face under each vertex at rest, (RINGS, SPOKES, 3)."""
    lips = Lips(rest, jaw)

    def shape(pose: Pose) -> Shape:
        grid = lips.grid(pose.mouth)
        return Shape(grid.reshape(-1, 3), patched(grid, skin_normals, _SMOOTHED).reshape(-1, 3))

    return Motion(shape, _mouth_state)


def cavity_motion(rest: Array, jaw: Array) -> Motion:
    """Return the motion of the dark behind the lips, which follows them."""
    lips = Lips(rest, jaw)
    normals = np.tile(np.asarray((0.0, -1.0, 0.0)), (cavity(rest[0]).size // 3, 1))

    def shape(pose: Pose) -> Shape:
        return Shape(cavity(lips.grid(pose.mouth)[0]).reshape(-1, 3), normals)

    return Motion(shape, _mouth_state)


def _mouth_state(pose: Pose) -> State:
    shape = pose.mouth
    return stepped(shape.jaw, shape.wide, shape.round, shape.upper, shape.lower, shape.press, shape.bite, shape.smile)


def upper_teeth_motion(vertices: Array, normals: Array) -> Motion:
    """Return the motion of the upper teeth, which hide behind rounded lips."""
    return _jawed(vertices, normals, 0.0, lambda pose: np.asarray(TEETH_HIDE) * pose.mouth.round)


def lower_teeth_motion(vertices: Array, normals: Array) -> Motion:
    """Return the motion of the lower teeth, which follow the jaw."""
    return _jawed(vertices, normals, 1.0, lambda pose: np.zeros(3))


def tongue_motion(vertices: Array, normals: Array) -> Motion:
    """Return the motion of the tongue, which follows the jaw, and rises."""
    return _jawed(vertices, normals, 0.9, lambda pose: np.asarray(TONGUE_LIFT) * pose.mouth.tongue)


def _jawed(vertices: Array, normals: Array, share: float, shift: Callable[[Pose], Array]) -> Motion:
    """Return the motion of vertices that follow the jaw by `share`, and are shifted (dm) by the pose."""
    shares = np.full(len(vertices), share)

    def shape(pose: Pose) -> Shape:
        return Shape(jaw_turned(vertices + shift(pose), shares, JAW_ANGLE * pose.mouth.jaw), normals)

    return Motion(shape, lambda pose: stepped(pose.mouth.jaw, *shift(pose)))
