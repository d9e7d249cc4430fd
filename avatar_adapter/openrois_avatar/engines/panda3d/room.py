"""The room in Panda3D: wall, floor, furniture, the visitor, and a soft shadow under each figure."""

from typing import Final

import numpy as np
from panda3d.core import NodePath, TransparencyAttrib

from openrois_avatar.engines import palette
from openrois_avatar.engines.figure import visitor
from openrois_avatar.engines.figure.baked import read
from openrois_avatar.engines.figure.mesh import Array, Mesh, grid_faces
from openrois_avatar.engines.figure.shading import CLOTH, PLAIN, Bytes, Floats, Lighting, Surface, linear
from openrois_avatar.engines.panda3d.geometry import Solid, matrix, show
from openrois_avatar.engines.room.scene import OtherFigure, Scene
from openrois_avatar.engines.room.shot import EYE_LEVEL, GROUND, HOME_SHOT, METRE

_WALL: Final = 30.0
"""How far behind the figure's home the wall is, in dm."""
_ASIDE, _BEFORE, _TOP = 24.0, -20.0, 34.0
"""How far to the sides and before the figure's home the other walls are, and how high they go, in dm."""
_UNDER: Final = 0.15
"""How far the ground is under the floor, and shadows over it, in dm: from far away the renderer's depth is no finer."""
_RELIGHT: Final = 0.05
"""The visitor is lit again once it has turned by about so many radians."""
_SHADOW: Final = 75
"""How dark a shadow is in its middle, 0 to 255."""


class Room:
    """Everything in the scene but the figure. The nearest is drawn first."""

    def __init__(self, scene: NodePath) -> None:
        self._all: NodePath = scene.attach_new_node("room")
        scene = self._all
        self._visitor = _Visitor(scene)
        meshes = {piece.name: piece.mesh() for piece in read("room")}
        self._furniture = _still("furniture", scene, meshes["furniture"])
        self._below = [_still("floor", scene, meshes["floor"]), _ground(scene)]
        _wall(scene)
        self._around = _walls_around(scene)
        self._shadows = [_shadow(scene), _shadow(scene)]

    def show(self, visible: bool) -> None:
        """Draw the room from now on, or do not."""
        show(self._all, visible)

    def update(self, scene: Scene) -> None:
        """Update places and visibility. Close views see no floor, the one at home no furniture."""
        self._furniture.show(scene.shot != HOME_SHOT)
        self._around.show(scene.shot.own)
        for solid in self._below:
            solid.show(not scene.shot.is_close)
        self._shadows[0].show(not scene.shot.is_close and not scene.shot.own)
        self._visitor.update(scene.visitor)
        self._shadows[1].show(scene.visitor is not None and not scene.shot.is_close)
        places = [scene.place] if scene.visitor is None else [scene.place, scene.visitor.place]
        for shadow, place in zip(self._shadows, places, strict=False):
            shadow.path.set_pos(place.x * METRE, place.y * METRE, GROUND + _UNDER)


class _Visitor:
    """The visitor's limbs, each a mesh that is only moved."""

    def __init__(self, scene: NodePath) -> None:
        self._limbs = []
        for name, mesh in visitor.build().items():
            solid = Solid(name, scene, mesh.faces, len(mesh.vertices))
            solid.move(mesh.vertices.astype(np.float32))
            lighting = Lighting([Surface(mesh.albedo, finish=CLOTH)])
            self._limbs.append((name, solid, mesh.normals.astype(np.float32), lighting))
        self._rotation: Floats | None = None

    def update(self, other: OtherFigure | None) -> None:
        """Show the visitor at its place, if there is one."""
        for _, solid, _, _ in self._limbs:
            solid.show(other is not None)
        if other is None:
            return
        frames = visitor.frames(other)
        for name, solid, _, _ in self._limbs:
            solid.path.set_mat(matrix(frames[name]))
        rotation = frames["hips"].rotation
        if self._rotation is None or float(np.abs(rotation - self._rotation).max()) > _RELIGHT:
            self._rotation = rotation.astype(np.float32)
            for _, solid, normals, lighting in self._limbs:
                solid.paint(_opaque(lighting.colours(slice(None), normals, self._rotation)))


def _opaque(colours: Bytes) -> Bytes:
    return np.concatenate([colours, np.full((len(colours), 1), 255, np.uint8)], axis=1)


def _still(name: str, scene: NodePath, mesh: Mesh) -> Solid:
    """A mesh that never moves."""
    solid = Solid(name, scene, mesh.faces, len(mesh.vertices))
    solid.move(mesh.vertices.astype(np.float32))
    light = Lighting([Surface(mesh.albedo, finish=PLAIN)])
    solid.paint(_opaque(light.colours(slice(None), mesh.normals.astype(np.float32), np.eye(3, dtype=np.float32))))
    return solid


def _shadow(scene: NodePath) -> Solid:
    """A disc that darkens the floor, most in its middle."""
    angle = np.arange(24) * 2 * np.pi / 24
    circle = np.stack([np.cos(angle) * 1.15, np.sin(angle), 0 * angle], axis=1)
    points = np.concatenate([circle * radius for radius in (0.05, 2.1)])
    colours = np.zeros((len(points), 4), np.uint8)
    colours[:, 3] = np.repeat((_SHADOW, 0), 24)
    solid = Solid("shadow", scene, grid_faces(2, 24, closed=True)[:, ::-1], len(points))
    solid.move(points.astype(np.float32))
    solid.paint(colours)
    solid.path.set_transparency(TransparencyAttrib.M_alpha)
    solid.path.set_depth_write(False)
    return solid


def _ground(scene: NodePath) -> Solid:
    """Return the ground around the floor; it gets dark towards the sides, as the wall does."""
    columns, rows = np.linspace(-75, 75, 31), np.linspace(-45, _WALL, 16)
    y, x = np.meshgrid(rows, columns, indexing="ij")
    points = np.stack([x, y, np.full_like(x, GROUND - _UNDER)], axis=-1).reshape(-1, 3)
    share = 1 - np.exp(-((x / 26.0) ** 2) - ((y - 8.0) / 26.0) ** 2).reshape(-1, 1)
    solid = Solid("ground", scene, grid_faces(len(rows), len(columns), closed=False), len(points))
    solid.move(points.astype(np.float32))
    solid.paint(_mixed(palette.GROUND, palette.BACKDROP_EDGE, share))
    return solid


def _wall(scene: NodePath) -> Solid:
    """A soft light on the wall behind the figure."""
    columns = np.concatenate([[-75.0, -40.0], np.linspace(-24, 24, 49), [40.0, 75.0]])
    rows = np.concatenate([[GROUND - _UNDER - EYE_LEVEL], np.linspace(-9, 9, 23)])
    z, x = np.meshgrid(rows, columns, indexing="ij")
    vertices = np.stack([x, np.full_like(x, _WALL), z + EYE_LEVEL], axis=-1).reshape(-1, 3)
    share = 1 - np.exp(-((x / 7.0) ** 2) - ((z - 0.8) / 5.2) ** 2).reshape(-1, 1)
    wall = Solid("wall", scene, grid_faces(len(rows), len(columns), closed=False), len(vertices))
    wall.move(vertices.astype(np.float32))
    wall.paint(_mixed(palette.BACKDROP_CENTRE, palette.BACKDROP_EDGE, share))
    return wall


def _walls_around(scene: NodePath) -> Solid:
    """The walls on all sides, as high as the figure's own eyes see them; the soft light is drawn before its own."""
    behind = _WALL + _UNDER
    corners = np.asarray(
        [(-_ASIDE, behind), (-_ASIDE, _BEFORE), (_ASIDE, _BEFORE), (_ASIDE, behind), (-_ASIDE, behind)]
    )
    along = np.linspace(0, 4, 61)
    heights = np.linspace(GROUND - _UNDER, _TOP, 24)
    z, side = (each.ravel() for each in np.meshgrid(heights, along, indexing="ij"))
    x, y = (np.interp(side, np.arange(5), corners[:, axis]) for axis in (0, 1))
    share = 1 - 0.6 * np.exp(-((z / 12.0) ** 2) - ((side % 1 - 0.5) / 0.35) ** 2) * (side < 3)
    walls = Solid("walls around", scene, grid_faces(len(heights), len(along), closed=False)[:, ::-1], len(z))
    walls.move(np.stack([x, y, z], axis=-1).astype(np.float32))
    walls.paint(_mixed(palette.BACKDROP_CENTRE, palette.BACKDROP_EDGE, share[:, None]))
    return walls


def _mixed(one: str, other: str, share: Array) -> Bytes:
    colours = np.sqrt(linear(one)) * (1 - share) + np.sqrt(linear(other)) * share
    return _opaque((colours * 255).astype(np.uint8))
