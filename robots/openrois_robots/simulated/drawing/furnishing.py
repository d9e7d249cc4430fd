"""What the rooms look like: floor, walls, furniture, persons and the charging mat as meshes. Pure."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from openrois_body.messages import Point

from openrois_robots.simulated.drawing.meshes import Mesh, ball, box, disc, plane, tube
from openrois_robots.simulated.world.plan import Furniture, Mat, Person, Plan, Room, Wall, Window

__all__ = [
    "CEILING",
    "HEAD",
    "HIPS",
    "floor_mesh",
    "furniture_mesh",
    "mat_mesh",
    "person_body",
    "person_head",
    "person_leg",
    "walls_mesh",
    "window_mesh",
]

CEILING: Final = 2.5
"""Metres from floor to ceiling."""
HEAD: Final = 1.6
HIPS: Final = 0.86
"""Metres to the middle of a person's head, and to the joints of the legs."""
_STEP: Final = 0.5
_THIN: Final = 0.05
_SHELVES: Final = 5
_SKIRTING: Final = 0.08
_SILL, _TALL = 0.95, 1.15
"""Metres of a window's lower edge above the floor, and its height."""
_BAR: Final = 0.03
_HORIZON: Final = 0.3
"""Share of a window's height over which the sky is seen."""
_FRAME: Final = (0.96, 0.96, 0.95)


def floor_mesh(room: Room) -> Mesh:
    """Return a room's floor, which is lighter in its middle; its texture repeats every two metres."""
    wide, deep = room.right - room.left, room.top - room.bottom
    mesh = plane((room.left, room.bottom, 0), (wide, 0, 0), (0, deep, 0), room.floor, _STEP)
    share = 1 - np.abs(mesh.places * 2 - 1).max(axis=1)
    colours = mesh.colours * (0.9 + 0.35 * np.clip(share, 0, 0.7))[:, None]
    places = (mesh.vertices[:, :2] / 2).astype(np.float32)
    return Mesh(mesh.vertices, np.clip(colours, 0, 1).astype(np.float32), places, mesh.faces)


def walls_mesh(plan: Plan) -> Mesh:
    """Return all walls, each side in the colour of its room, with skirting boards, and the ceilings."""
    outer = (mesh for room in plan.rooms for start, end in _edges(plan, room) for mesh in _side(plan, start, end))
    inner = (mesh for wall in plan.walls for start, end in _around(wall) for mesh in _side(plan, start, end))
    return Mesh.joined([*outer, *inner, *map(_ceiling, plan.rooms)])


def _edges(plan: Plan, room: Room) -> Iterator[tuple[Point, Point]]:
    """Yield the sides of a room that are outer walls, with the room on the left."""
    if room.bottom == plan.bottom:
        yield (room.left, room.bottom), (room.right, room.bottom)
    if room.right == plan.right:
        yield (room.right, room.bottom), (room.right, room.top)
    if room.top == plan.top:
        yield (room.right, room.top), (room.left, room.top)
    if room.left == plan.left:
        yield (room.left, room.top), (room.left, room.bottom)


def _ceiling(room: Room) -> Mesh:
    wide, deep = room.right - room.left, room.top - room.bottom
    mesh = plane((room.left, room.top, CEILING), (wide, 0, 0), (0, -deep, 0), (0.97, 0.97, 0.95), 1.0)
    return Mesh(mesh.vertices, np.full_like(mesh.colours, 0.86), mesh.places, mesh.faces)


def _around(wall: Wall) -> Iterator[tuple[Point, Point]]:
    """Yield the sides of a wall, with the outside on the left."""
    corners = [(wall.left, wall.bottom), (wall.left, wall.top), (wall.right, wall.top), (wall.right, wall.bottom)]
    yield from zip(corners, (*corners[1:], corners[0]), strict=True)


def _side(plan: Plan, start: Point, end: Point) -> Iterator[Mesh]:
    """Yield one side of a wall, seen with its room on the left of the way from `start` to `end`."""
    (x, y), (along, across) = start, (end[0] - start[0], end[1] - start[1])
    length = float(np.hypot(along, across))
    inwards = -across / length, along / length
    beside = (x + along / 2 + inwards[0] * 0.1, y + across / 2 + inwards[1] * 0.1)
    colour = next(
        (
            each.walls
            for each in plan.rooms
            if each.left <= beside[0] <= each.right and each.bottom <= beside[1] <= each.top
        ),
        (0.8, 0.8, 0.8),
    )
    # Seen from inside the end is on the left: the front of a plane is where `along` turns to `up`.
    mesh = plane((end[0], end[1], _SKIRTING), (-along, -across, 0), (0, 0, CEILING - _SKIRTING), colour, _STEP)
    # A wall is lighter in its middle, and towards the ceiling, where the light is.
    light = 0.9 + 0.12 * np.sin(np.pi * mesh.places[:, 0]) + 0.08 * mesh.places[:, 1]
    colours = np.clip(mesh.colours * light[:, None], 0, 1).astype(np.float32)
    yield Mesh(mesh.vertices, colours, mesh.places, mesh.faces)
    yield plane((end[0], end[1], 0), (-along, -across, 0), (0, 0, _SKIRTING), (0.95, 0.94, 0.92), 1.0)


def window_mesh(window: Window) -> Mesh:
    """Return a window with its frame: the sky above, and something green below it."""
    low, high, half = _SILL, _SILL + _TALL, window.width / 2
    pane = plane((_THIN / 2, -half, low), (0, window.width, 0), (0, 0, _TALL), (1.0, 1.0, 1.0), 0.25)
    share = pane.places[:, 1:2]
    sky = np.where(share > _HORIZON, (0.66, 0.82, 0.97) + (1 - share) * 0.25, (0.5, 0.62, 0.42) + share * 0.3)
    panes = Mesh(pane.vertices, np.clip(sky, 0, 1).astype(np.float32), pane.places, pane.faces)
    bars = [box((0.0, y - _BAR, low - _BAR), (_THIN, y + _BAR, high + _BAR), _FRAME) for y in (-half, 0.0, half)] + [
        box((0.0, -half, z - _BAR), (_THIN, half, z + _BAR), _FRAME, 2.0) for z in (low, high)
    ]
    sill = box((0.0, -half - 0.1, low - 2 * _BAR), (0.18, half + 0.1, low - _BAR), _FRAME, 2.0)
    return Mesh.joined([panes, *bars, sill]).turned(window.th, window.x, window.y)


def mat_mesh(mat: Mat) -> Mesh:
    """Return the charging mat: a ring around a dark disc."""
    return Mesh.joined(
        [
            disc(mat.x, mat.y, 0.004, mat.radius, (0.16, 0.5, 0.36), (0.2, 0.72, 0.5)),
            disc(mat.x, mat.y, 0.008, mat.radius * 0.82, (0.16, 0.18, 0.22), (0.12, 0.14, 0.18)),
        ]
    )


def furniture_mesh(piece: Furniture) -> Mesh:
    """Return a piece of furniture at its place."""
    (x, y), *_ = piece.outline
    right, top = x + piece.width, y + piece.depth
    match piece.look:
        case "table":
            legs = [
                box((a - _THIN, b - _THIN, 0), (a + _THIN, b + _THIN, piece.height - _THIN), _darker(piece.colour))
                for a in (x + 2 * _THIN, right - 2 * _THIN)
                for b in (y + 2 * _THIN, top - 2 * _THIN)
            ]
            return Mesh.joined([*legs, box((x, y, piece.height - _THIN), (right, top, piece.height), piece.colour)])
        case "sofa":
            return Mesh.joined(
                [
                    box((x, y, 0.1), (right, top, 0.45), piece.colour),
                    box((x, y, 0.45), (x + 0.25, top, piece.height), _darker(piece.colour)),
                    box((x, y, 0.45), (right, y + 0.2, 0.62), _darker(piece.colour)),
                    box((x, top - 0.2, 0.45), (right, top, 0.62), _darker(piece.colour)),
                ]
            )
        case "shelf":
            return _shelf(piece)
        case "plant":
            pot = tube([(0, 0.14, 0), (0.35, 0.2, 0)], (0.7, 0.4, 0.28))
            leaves = [
                ball(0.5 + 0.17 * n, 0.1 + 0.13 * (n % 3), 0.2, piece.colour).turned(
                    n * 2.1, 0.08 * (n % 2), 0.05 * (n % 3)
                )
                for n in range(5)
            ]
            return Mesh.joined([pot, *leaves]).turned(0, piece.x, piece.y)
        case "lamp":
            foot, pole = (
                tube([(0, 0.16, 0), (0.04, 0.15, 0)], (0.3, 0.3, 0.32)),
                tube([(0, 0.02, 0), (1.4, 0.02, 0)], (0.3, 0.3, 0.32), 6),
            )
            shade = tube([(1.3, 0.2, 0), (1.7, 0.13, 0)], piece.colour)
            return Mesh.joined([foot, pole, shade]).turned(0, piece.x, piece.y)
        case _:
            return Mesh.joined(
                [
                    box((x, y, 0), (right, top, piece.height - _THIN), piece.colour),
                    box((x - 0.01, y - 0.02, piece.height - _THIN), (right, top, piece.height), _darker(piece.colour)),
                ]
            )


def _shelf(piece: Furniture) -> Mesh:
    """Return a shelf with books in the colours of a library."""
    (x, y), *_ = piece.outline
    right, top = x + piece.width, y + piece.depth
    # The open side faces the middle of the building.
    front, back = (y, top) if piece.y > 0 else (top, y)
    inwards = 1 if back > front else -1
    parts = [
        box(
            (x, min(front + inwards * 0.04, back), 0),
            (right, max(front + inwards * 0.04, back), piece.height),
            _darker(piece.colour),
        )
    ]
    random = np.random.default_rng(len(piece.name))
    height = piece.height / _SHELVES
    low, high = sorted((front, front + inwards * 0.06))
    for number in range(_SHELVES + 1):
        level = min(number * height, piece.height - _THIN)
        parts.append(box((x, low, level), (right, high, level + _THIN), piece.colour, 2.0))
    for number in range(_SHELVES):
        at = x + 0.06
        while at < right - 0.3:
            wide, tall = random.uniform(0.08, 0.22), random.uniform(0.55, 0.82) * height
            tint = tuple(float(each) for each in random.uniform(0.25, 0.8, 3))
            level = number * height + _THIN
            parts.append(
                box((at, low + 0.01, level), (at + wide, high - 0.01, level + tall), (tint[0], tint[1], tint[2]), 2.0)
            )
            at += wide + random.uniform(0.01, 0.12)
    return Mesh.joined(parts)


def person_body(person: Person) -> Mesh:
    """Return a person's body without head and legs, at the origin and facing along x."""
    trunk = tube(
        [
            (0.8, 0.15, 0),
            (0.86, 0.165, 0),
            (1.0, 0.155, 0),
            (1.2, 0.175, 0),
            (1.34, 0.185, 0),
            (1.42, 0.13, 0),
            (1.46, 0.06, 0),
        ],
        person.clothes,
        flat=0.62,
    )
    neck = tube([(1.42, 0.055, 0), (1.54, 0.05, 0.01)], _darker(person.skin), 8)
    arms = [
        Mesh.joined(
            [
                tube(
                    [(0.9, 0.035, 0.06), (1.14, 0.043, 0), (1.3, 0.055, 0), (1.38, 0.05, 0), (1.41, 0.01, 0)],
                    person.clothes,
                    8,
                ),
                ball(0.86, 0.04, 0.065, person.skin, ahead=0.065),
            ]
        ).turned(0, 0, side * 0.205)
        for side in (-1, 1)
    ]
    return Mesh.joined([trunk, neck, *arms])


def person_leg(person: Person, side: int) -> Mesh:
    """Return the left (1) or right (-1) leg of a person, below its joint, and facing along x."""
    leg = tube([(0.0, 0.055, 0.0), (0.06, 0.06, 0.0), (0.45, 0.072, 0.01), (0.86, 0.095, 0.0)], person.trousers, 8)
    shoe = box((-0.07, -0.05, 0), (0.15, 0.05, 0.07), (0.15, 0.12, 0.1))
    whole = Mesh.joined([leg, shoe]).turned(0, 0, side * 0.085)
    return Mesh(whole.vertices - np.asarray((0, 0, HIPS), np.float32), whole.colours, whole.places, whole.faces)


def person_head() -> Mesh:
    """Return a head in white, for a texture, at the origin and facing along x."""
    head = ball(HEAD, 0.08, 0.118, (1.0, 1.0, 1.0), deep=0.095, ahead=0.015)
    # The light of a room comes from all sides: a chin is not as dark as the underside of a shelf.
    return Mesh(head.vertices, (0.45 + 0.55 * head.colours).astype(np.float32), head.places, head.faces)


def _darker(colour: tuple[float, float, float]) -> tuple[float, float, float]:
    return 0.78 * colour[0], 0.78 * colour[1], 0.78 * colour[2]
