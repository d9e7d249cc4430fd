"""The room as a drawing: a wall with a soft light, the floor, and what stands on it."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
from openrois_body.messages.motion import Point

from openrois_avatar.engines import palette
from openrois_avatar.engines.puppet.canvas import Canvas, Colour, colour, mixed
from openrois_avatar.engines.puppet.curves import Array, ellipse, ribbon, spline
from openrois_avatar.engines.puppet.view import Lens
from openrois_avatar.engines.room.plan import PILLAR, PLANT, RADIO, ROOM, STOOL, TABLE, box, round_
from openrois_avatar.engines.room.shot import GROUND, METRE
from openrois_avatar.engines.settings import Pixels
from openrois_avatar.link.messages import Place

Drawn = tuple[float, Callable[[Canvas, Lens], None]]
"""How far away something is (dm from the home of the figure), and how to draw it."""
_WALL: Final = 30.0
"""How far behind the figure's home the wall is, in dm."""
_MIDDLE: Final = np.asarray(((0.0, _WALL, 0.0),))
_COARSE: Final = 8
"""The wall is moved at a size so many times smaller than the drawing."""
_BESIDE: Final = 90.0
"""Half the width of what is drawn of the ground, in dm."""
_BEFORE: Final = 3.0
"""How far before the camera (dm) the floor begins at least, and what stands nearer is left out."""
_PLANKS: Final = 15
_GAP: Final = 0.04
"""Half the width of the gap between two planks, in dm."""
_LEAVES: Final = 9
_GROUND = mixed(palette.GROUND, palette.BACKDROP_EDGE, 0.5)
_LINE = mixed(palette.FLOOR_DARK, palette.WOOD, 0.35)
_SHADOW: Final = 60


class Wall:
    """The wall in the close view of home, from which it is made larger or smaller for other shots."""

    def __init__(self, lens: Lens) -> None:
        self.close = _backdrop(lens)
        size = (lens.width // _COARSE, lens.height // _COARSE)
        # A soft light has no more to show than that.
        self._coarse = cv2.resize(self.close, size, interpolation=cv2.INTER_AREA)
        self._moved = np.empty_like(self._coarse)
        self._depth, self._home = float(lens.depths(_MIDDLE)[0]), lens.seen(_MIDDLE)[0]

    def draw(self, pixels: Pixels, lens: Lens) -> None:
        """Fill a drawing (height, width, 4) with the wall as this lens shows it."""
        scale = self._depth / float(lens.depths(_MIDDLE)[0])
        left, top = (lens.seen(_MIDDLE)[0] - self._home * scale) / _COARSE
        turn = np.asarray(((scale, 0.0, left), (0.0, scale, top)))
        height, width = self._coarse.shape[:2]
        cv2.warpAffine(self._coarse, turn, (width, height), dst=self._moved, borderMode=cv2.BORDER_REPLICATE)
        cv2.resize(self._moved, (lens.width, lens.height), dst=pixels, interpolation=cv2.INTER_LINEAR)


def draw_floor(canvas: Canvas, lens: Lens) -> None:
    """Ground and floor, as far as they are before the camera."""
    front = max(ROOM.outline[0][1] * METRE, lens.shot.y + _BEFORE)
    nearest = lens.shot.y + _BEFORE
    canvas.fill(_level(lens, ((-_BESIDE, nearest), (_BESIDE, nearest), (_BESIDE, _WALL), (-_BESIDE, _WALL))), _GROUND)
    (left, _), (right, _), (_, back), _ = (tuple(part * METRE for part in corner) for corner in ROOM.outline)
    canvas.fill(_level(lens, ((left, front), (right, front), (right, back), (left, back))), colour(palette.FLOOR))
    gap = ((-_GAP, front), (_GAP, front), (_GAP, back), (-_GAP, back))
    gaps = [(x + aside, y) for x in np.linspace(left, right, _PLANKS + 1) for aside, y in gap]
    for line in _level(lens, gaps).reshape(-1, 4, 2):
        canvas.fill(line, _LINE)


def draw_shadow(canvas: Canvas, lens: Lens, place: Place) -> None:
    """A soft shadow under a figure."""
    around = ellipse((0.0, 0.0, 0.0), (1.0, 0.8))[:, [0, 2, 1]]
    for radius in (2.0, 1.4):
        spot = around * radius + (place.x * METRE, place.y * METRE, GROUND)
        canvas.shadow(lens.seen(spot), colour(palette.LASH), _SHADOW // 2)


def furniture(lens: Lens) -> Iterator[Drawn]:
    """Yield the furniture before the camera: its depth, and how it is drawn."""
    pieces = {TABLE: _draw_table, PILLAR: _draw_pillar, PLANT: _draw_plant, STOOL: _draw_stool}
    for piece, draw in pieces.items():
        if (piece.y - piece.reach) * METRE > lens.shot.y + _BEFORE:
            yield piece.y * METRE, draw


def _draw_table(canvas: Canvas, lens: Lens) -> None:
    for x, y in sorted(TABLE.outline, key=lambda corner: -corner[1]):
        leg = box(x + (0.05 if x < TABLE.x else -0.05), y + (0.05 if y < TABLE.y else -0.05), 0.07, 0.07)
        _draw_prism(canvas, lens, leg, 0.0, TABLE.height, palette.WOOD_DARK)
    _draw_prism(canvas, lens, TABLE.outline, TABLE.height - 0.06, TABLE.height, palette.WOOD)
    height = TABLE.height
    _draw_prism(canvas, lens, box(RADIO.x, RADIO.y, 0.34, 0.16), height, height + 0.22, palette.RADIO)
    face = box(RADIO.x - 0.05, RADIO.y - 0.085, 0.16, 0.01)
    _draw_prism(canvas, lens, face, height + 0.04, height + 0.18, palette.RADIO_FACE)


def _draw_pillar(canvas: Canvas, lens: Lens) -> None:
    _draw_prism(canvas, lens, PILLAR.outline, 0.0, PILLAR.height, palette.PILLAR)


def _draw_plant(canvas: Canvas, lens: Lens) -> None:
    middle = np.asarray((PLANT.x, PLANT.y)) * METRE
    for number in range(_LEAVES):
        out = (number - (_LEAVES - 1) / 2) / _LEAVES
        high = PLANT.height * (1.0 - 0.5 * abs(out) - 0.12 * (number % 2)) * METRE
        shape = ((0.0, 0.3 * METRE), (out * 1.2, high * 0.7), (out * 4.2, high))
        points = np.asarray([(middle[0] + x, middle[1], GROUND + z) for x, z in shape])
        line = spline(lens.seen(points), 6)
        unit = float(lens.unit(points)[0])
        width = 0.42 * unit * np.linspace(1.0, 0.05, len(line))
        canvas.fill(ribbon(line, width), mixed(palette.LEAF_DARK, palette.LEAF, (number % 3) / 2))
    _draw_prism(canvas, lens, round_(PLANT.x, PLANT.y, 0.22), 0.0, 0.36, palette.POT)


def _draw_stool(canvas: Canvas, lens: Lens) -> None:
    _draw_prism(canvas, lens, round_(STOOL.x, STOOL.y, 0.17, 12), 0.0, STOOL.height - 0.14, palette.WOOD_DARK)
    _draw_prism(canvas, lens, round_(STOOL.x, STOOL.y, 0.24, 12), STOOL.height - 0.14, STOOL.height, palette.CUSHION)


def _draw_prism(canvas: Canvas, lens: Lens, outline: Sequence[Point], low: float, high: float, paint: str) -> None:
    """Draw a prism over an outline (metres, counter-clockwise), between two heights above the floor in metres."""
    corners = np.asarray(outline) * METRE
    bottom, top = (
        lens.seen(np.concatenate([corners, np.full((len(corners), 1), GROUND + height * METRE)], axis=1))
        for height in (low, high)
    )
    around = [*range(len(corners)), 0]
    for first, second in pairwise(around):
        out = np.asarray((corners[second, 1] - corners[first, 1], corners[first, 0] - corners[second, 0]))
        if out @ (corners[first] - (lens.shot.x, lens.shot.y)) < 0:
            side = np.stack([bottom[first], bottom[second], top[second], top[first]])
            canvas.fill(side, _lit(paint, out / np.linalg.norm(out)))
    if lens.shot.z > GROUND + high * METRE:
        canvas.fill(top, mixed(paint, palette.COLLAR, 0.12))


def _lit(paint: str, out: Array) -> Colour:
    """A side's colour: light comes from the left and the front."""
    return mixed(paint, palette.LASH, 0.18 + 0.16 * float(out[0]))


def _level(lens: Lens, corners: Sequence[tuple[float, float]]) -> Array:
    """Corners on the floor, in dm, in pixels."""
    return lens.seen(np.asarray([(x, y, GROUND) for x, y in corners]))


def _backdrop(lens: Lens) -> Pixels:
    """A soft light on a wall."""
    x = (np.arange(lens.width, dtype=np.float32) - lens.width / 2) / lens.scale
    z = (lens.height / 2 - np.arange(lens.height, dtype=np.float32)) / lens.scale
    share = 1 - np.outer(np.exp(-(((z - 0.5) / 2.0) ** 2)), np.exp(-((x / 2.5) ** 2)))
    centre, edge = (np.asarray(colour(part)[::-1]) for part in (palette.BACKDROP_CENTRE, palette.BACKDROP_EDGE))
    pixels = np.full((lens.height, lens.width, 4), 255, np.uint8)
    # Noise of less than a step keeps a slow change of colour from showing bands.
    grain = np.random.default_rng(1).random(share.shape, np.float32)
    for channel in range(3):
        pixels[:, :, channel] = share * (edge[channel] - centre[channel]) + (grain + centre[channel])
    return pixels
