"""The parts of the head that are skin: skull and jaw, lids, lips, ears."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Mouth, Pose
from openrois_avatar.engines.sculpt import head, lids, mouth, paint
from openrois_avatar.engines.sculpt.distance import Array, ellipsoid, occlusion
from openrois_avatar.engines.sculpt.mesh import Mesh, compact, grid_faces, grid_normals, polygonised, without
from openrois_avatar.engines.sculpt.part import (
    Part,
    Shape,
    State,
    both_ways,
    mirrored_mesh,
    mirrored_shape,
    plain,
    sided,
    stepped,
    still,
    towards,
)
from openrois_avatar.engines.sculpt.shading import PLAIN, SKIN, Surface, linear

_SKIN_GLOSS = 0.09
_LIP_GLOSS = 0.24


def parts(depth: head.DepthMap, shadow: paint.Shadow) -> list[Part]:
    """Every skin part of the head; `shadow` darkens what lies under the hair."""
    return [
        _skull(shadow),
        *_ear(),
        _lips(depth, shadow),
        *_inside_mouth(depth),
        *(_lid(depth, shadow, side) for side in (1, -1)),
    ]


def lid_state(pose: Pose, side: int) -> tuple[float, float, float]:
    """Lid, squint and wide of one eye, with the part of it that follows the gaze up and down."""
    return _lid_state(pose.lid_left if side > 0 else pose.lid_right, pose.gaze_pitch, pose.squint, pose.wide)


# Lids, lashes and eyeball of an eye ask for it in turn.
@lru_cache(maxsize=4)
def _lid_state(lid: float, gaze_pitch: float, squint: float, wide: float) -> tuple[float, float, float]:
    follow = max(-gaze_pitch, 0.0) * 0.9 - max(gaze_pitch, 0.0) * 0.4
    values = stepped(min(max(lid + (1 - lid) * follow, -0.15), 1.0), squint, wide)
    return values[0], values[1], values[2]


def _skull(shadow: paint.Shadow) -> Part:
    points, normals, faces = polygonised(head.face_field, (-1.0, -1.2, -1.1), (1.0, 1.2, 1.3), 0.05)
    hair_side = (points[:, 1] > 0.22) | (points[:, 2] > 0.88)
    faces = without(without(faces, head.in_patch(points, 0.06)), hair_side)
    openness = paint.veil(occlusion(head.face_field, points, normals)) * shadow(points)
    skull = compact(Mesh(points, normals, faces, paint.skin(points), openness))
    share = head.jaw_share(skull.vertices)
    moving = np.flatnonzero(share > 1e-3)

    def shape(pose: Pose) -> Shape:
        vertices = skull.vertices.copy()
        vertices[moving] = head.jaw_turned(vertices[moving], share[moving], mouth.JAW_ANGLE * pose.mouth.jaw)
        return Shape(vertices, skull.normals)

    surface = Surface(skull.albedo, skull.openness, SKIN, _SKIN_GLOSS)
    return Part("skull", "head", skull.faces, surface, shape, lambda pose: stepped(pose.mouth.jaw))


def _ear() -> list[Part]:
    """The right ear with its earring; the hair falls over the left one."""
    points, normals, faces = polygonised(head.ear_field, (0.62, -0.30, -0.50), (1.05, 0.35, 0.25), 0.036)
    openness = occlusion(head.ear_field, points, normals, 0.12)
    ear = Mesh(points, normals, faces, paint.ear(points, openness), paint.veil(openness))
    place = np.asarray(head.PEARL)
    points, normals, faces = polygonised(lambda p: ellipsoid(p, place, (0.042,) * 3), place - 0.07, place + 0.07, 0.024)
    pearl = Mesh(points, normals, faces, np.tile(linear(palette.PEARL), (len(points), 1)), np.ones(len(points)))
    return [
        still("ear", "head", mirrored_mesh(ear), SKIN, _SKIN_GLOSS),
        still("pearl", "head", mirrored_mesh(pearl), SKIN, 0.5),
    ]


def _patched(grid: Array, skin: Array, smoothed: npt.ArrayLike = 0.0) -> Array:
    """Normals of a patch of skin that become those of the face: under its last rings, and where it is `smoothed`."""
    normals = -grid_normals(grid, closed=True)
    border = head.smooth((np.arange(len(grid)) - len(grid) + 5) / 3)[:, None]
    share = np.maximum(border, smoothed)[:, :, None]
    normals = normals * (1 - share) + skin * share
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-9))


def _openness(grid: Array, depth: head.DepthMap) -> Array:
    """Openness of the smooth face under a patch, (n,): the same as the skull's where they meet."""
    x, z = grid[..., 0], grid[..., 2]
    surface = np.stack([x, depth(x, z), z], axis=-1).reshape(-1, 3)
    return paint.veil(occlusion(head.face_field, surface, depth.normals(x, z).reshape(-1, 3)))


def _lid(depth: head.DepthMap, shadow: paint.Shadow, side: int) -> Part:
    model = lids.Lids(depth)
    rest = model.grid(0.0, 0.0, 0.0)
    flat = rest.reshape(-1, 3)
    albedo = paint.skin(flat).reshape(rest.shape)
    for ring, share in enumerate((0.75, 0.45, 0.28, 0.14, 0.05)):
        albedo[ring] += (linear(palette.LID_SHADE) - albedo[ring]) * share
    surface = Surface(albedo.reshape(-1, 3), _openness(rest, depth) * shadow(flat * (side, 1, 1)), SKIN, _SKIN_GLOSS)

    def shape(pose: Pose) -> Shape:
        grid = model.grid(*lid_state(pose, side))
        return mirrored_shape(Shape(grid.reshape(-1, 3), _patched(grid, model.skin_normals).reshape(-1, 3)), side)

    faces = sided(grid_faces(len(rest), lids.SPOKES, closed=True)[:, ::-1], side)
    return Part("lid", "head", faces, surface, shape, lambda pose: lid_state(pose, side))


def _mouth_state(pose: Pose) -> State:
    shape = pose.mouth
    return stepped(shape.jaw, shape.wide, shape.round, shape.upper, shape.lower, shape.press, shape.bite, shape.smile)


def _lips(depth: head.DepthMap, shadow: paint.Shadow) -> Part:
    model = mouth.Lips(depth)
    rest = model.grid(Mouth())
    albedo = paint.skin(rest.reshape(-1, 3)).reshape(rest.shape)
    gloss = np.full(rest.shape[:2], _SKIN_GLOSS)
    for ring in range(mouth.BORDER + 1):
        share = 1.0 if ring < mouth.BORDER else 0.45
        albedo[ring] += (linear(palette.LIPS) - albedo[ring]) * share
        gloss[ring] += (_LIP_GLOSS - gloss[ring]) * share
    albedo[: mouth.INSIDE + 1] *= np.asarray((0.12, 0.25, 0.5, 0.74))[:, None, None]
    gloss[: mouth.INSIDE] = 0.0
    surface = Surface(albedo.reshape(-1, 3), _openness(rest, depth) * shadow(rest.reshape(-1, 3)), SKIN, gloss.ravel())

    def shape(pose: Pose) -> Shape:
        grid = model.grid(pose.mouth)
        return Shape(grid.reshape(-1, 3), _patched(grid, model.skin_normals, model.smoothed).reshape(-1, 3))

    return Part(
        "lips", "head", grid_faces(mouth.RINGS, mouth.SPOKES, closed=True)[:, ::-1], surface, shape, _mouth_state
    )


def _inside_mouth(depth: head.DepthMap) -> list[Part]:
    def raised(pose: Pose) -> Array:
        return np.asarray(mouth.TONGUE_LIFT) * pose.mouth.tongue

    def hidden(pose: Pose) -> Array:
        return np.asarray(mouth.TEETH_HIDE) * pose.mouth.round

    def staying(pose: Pose) -> Array:
        return np.zeros(3)

    return [
        _jawed("upper teeth", mouth.teeth(upper=True), palette.TEETH, 0.0, mouth.teeth_openness(0.65), hidden),
        _jawed("lower teeth", mouth.teeth(upper=False), palette.TEETH, 1.0, mouth.teeth_openness(0.32), staying),
        _jawed("tongue", mouth.tongue(), palette.TONGUE, 0.9, 0.60, raised),
        _cavity(mouth.Lips(depth)),
    ]


def _cavity(lips: mouth.Lips) -> Part:
    rest = mouth.cavity(lips.grid(Mouth())[0])
    normals = np.tile(np.asarray((0.0, -1.0, 0.0)), (rest.size // 3, 1))

    def shape(pose: Pose) -> Shape:
        return Shape(mouth.cavity(lips.grid(pose.mouth)[0]).reshape(-1, 3), normals)

    faces = both_ways(grid_faces(rest.shape[0], rest.shape[1], closed=True))
    return Part("cavity", "head", faces, plain(palette.MOUTH_INSIDE, len(normals), PLAIN, 0.0), shape, _mouth_state)


def _jawed(
    name: str,
    grid: Array,
    colour: str,
    share: float,
    openness: npt.ArrayLike,
    shift: Callable[[Pose], Array],
    closed: bool = False,
) -> Part:
    """Something in the mouth that follows the jaw by `share` and is shifted (dm) by the pose."""
    normals = towards(grid_normals(grid, closed), np.asarray((0.0, -1.0, 0.0))).reshape(-1, 3)
    shares = np.full(grid.shape[:2], share)

    def shape(pose: Pose) -> Shape:
        moved = head.jaw_turned(grid + shift(pose), shares, mouth.JAW_ANGLE * pose.mouth.jaw)
        return Shape(moved.reshape(-1, 3), normals)

    faces = both_ways(grid_faces(grid.shape[0], grid.shape[1], closed))
    return Part(
        name,
        "head",
        faces,
        plain(colour, len(normals), PLAIN, openness),
        shape,
        lambda pose: stepped(pose.mouth.jaw, *shift(pose)),
    )
