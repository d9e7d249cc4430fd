"""The furniture of the room, as meshes in the world of the figure: decimetres from the middle of its head at home."""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, sin
from typing import Final

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.mesh import Array, Faces, Mesh
from openrois_avatar.engines.figure.shading import linear
from openrois_avatar.engines.room.plan import PILLAR, PLANT, RADIO, ROOM, STOOL, TABLE, Furniture, box, round_
from openrois_avatar.engines.room.shot import GROUND, METRE
from openrois_body.messages.motion import Point

from tools.sculpt.distance import cone
from tools.sculpt.mesh import merged, polygonised
from tools.sculpt.pieces import still

_PLANKS: Final = 15
_ROWS: Final = 6
_LEAVES: Final = 9


def pieces() -> list[Piece]:
    """Furniture and floor."""
    return [still(name, "room", "plain", mesh) for name, mesh in (("furniture", furniture()), ("floor", floor()))]


def floor() -> Mesh:
    """The floor that one can walk on: planks of two colours, darker towards the viewer."""
    (left, front), _, (right, back), _ = ROOM.outline
    random = np.random.default_rng(5)
    columns = np.linspace(left, right, _PLANKS + 1) * METRE
    rows = np.linspace(front, back, _ROWS) * METRE
    strips = []
    for first, last in pairwise(columns):
        x, y = np.meshgrid(np.asarray((first, last)), rows)
        points = np.stack([x, y, np.full_like(x, GROUND)], axis=-1).reshape(-1, 3)
        share = 0.35 * random.random() + 0.5 * np.clip((10.0 - points[:, 1:2]) / 30.0, 0, 1)
        albedo = linear(palette.FLOOR) * (1 - share) + linear(palette.FLOOR_DARK) * share
        strips.append(_flat(points, _strip(_ROWS), (0.0, 0.0, 1.0), albedo))
    return merged(strips)


def furniture() -> Mesh:
    """Table, radio, pillar, plant and stool."""
    return merged([*_table(), *_pillar(), *_plant(), *_stool()])


def _table() -> list[Mesh]:
    height, x, y = TABLE.height, TABLE.x, TABLE.y
    legs = [
        _prism(
            box(corner_x - 0.05 * side_x, corner_y - 0.05 * side_y, 0.07, 0.07), 0.0, height - 0.06, palette.WOOD_DARK
        )
        for (corner_x, corner_y) in TABLE.outline
        for side_x, side_y in [(1 if corner_x > x else -1, 1 if corner_y > y else -1)]
    ]
    radio = _prism(box(RADIO.x, RADIO.y, 0.34, 0.16), height, height + 0.22, palette.RADIO)
    face = _prism(box(RADIO.x - 0.05, RADIO.y - 0.085, 0.16, 0.01), height + 0.04, height + 0.18, palette.RADIO_FACE)
    return [_prism(TABLE.outline, height - 0.06, height, palette.WOOD), *legs, radio, face]


def _pillar() -> list[Mesh]:
    foot = box(PILLAR.x, PILLAR.y - 0.02, 0.46, 0.4)
    return [_prism(PILLAR.outline, 0.0, PILLAR.height, palette.PILLAR), _prism(foot, 0.0, 0.16, palette.PILLAR)]


def _plant() -> list[Mesh]:
    """A pot with long leaves."""
    middle = _dm(PLANT, 0.0)

    def leaves(points: Array) -> Array:
        distance = np.full(len(points), 9.0)
        for number in range(_LEAVES):
            turn, out = number * 2 * pi * 0.382, 0.06 + 0.20 * number / _LEAVES
            high = PLANT.height * (1.0 - 0.45 * number / _LEAVES)
            foot, tip = (np.asarray((cos(turn) * part, sin(turn) * part, 0.0)) * METRE for part in (0.05, out))
            start, end = middle + foot + (0, 0, 0.3 * METRE), middle + tip + (0, 0, high * METRE)
            distance = np.minimum(distance, cone(points, start, end, 0.55, 0.14))
        return distance

    reach = np.asarray((0.42, 0.42, PLANT.height + 0.1)) * METRE
    points, normals, faces = polygonised(leaves, middle - reach * (1, 1, 0), middle + reach, 0.34)
    share = np.clip((points[:, 2:] - GROUND) / (PLANT.height * METRE), 0, 1)
    albedo = linear(palette.LEAF_DARK) * (1 - share) + linear(palette.LEAF) * share
    pot = _prism(round_(PLANT.x, PLANT.y, 0.22), 0.0, 0.36, palette.POT)
    return [pot, Mesh(points, normals, faces, albedo, np.ones(len(points)))]


def _stool() -> list[Mesh]:
    under = _prism(round_(STOOL.x, STOOL.y, 0.17, 12), 0.0, STOOL.height - 0.14, palette.WOOD_DARK)
    return [under, _prism(round_(STOOL.x, STOOL.y, 0.24, 12), STOOL.height - 0.14, STOOL.height, palette.CUSHION)]


def _dm(piece: Furniture, height: float) -> Array:
    return np.asarray((piece.x * METRE, piece.y * METRE, GROUND + height * METRE))


def _prism(outline: Sequence[Point], low: float, high: float, colour: str) -> Mesh:
    """Return a prism over an outline (metres, counter-clockwise), between two heights above the floor in metres."""
    corners = np.asarray(outline) * METRE
    bottom, top = GROUND + low * METRE, GROUND + high * METRE
    lid = np.concatenate([corners, np.full((len(corners), 1), top)], axis=1)
    fan = np.asarray([(0, index, index + 1) for index in range(1, len(corners) - 1)], np.int32)
    made = [_flat(lid, fan, (0.0, 0.0, 1.0), linear(colour))]
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        side = np.asarray(((ax, ay, bottom), (bx, by, bottom), (bx, by, top), (ax, ay, top)))
        out = np.asarray((by - ay, ax - bx, 0.0))
        two = np.asarray(((0, 1, 2), (0, 2, 3)), np.int32)
        made.append(_flat(side, two, out / np.linalg.norm(out), linear(colour)))
    return merged(made)


def _flat(points: Array, faces: Faces, normal: Sequence[float] | Array, albedo: Array) -> Mesh:
    count = len(points)
    normals = np.tile(np.asarray(normal, float), (count, 1))
    return Mesh(points, normals, faces, np.broadcast_to(albedo, (count, 3)), np.ones(count))


def _strip(rows: int) -> Faces:
    """Triangles of rows of two points each."""
    first = np.arange(0, 2 * (rows - 1), 2)
    return np.concatenate(
        [np.stack([first, first + 1, first + 3], 1), np.stack([first, first + 3, first + 2], 1)]
    ).astype(np.int32)
