"""The eyes themselves: eyeballs with iris and catch-lights, and the parts that frame them, lashes and brows."""

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.face import lid_state
from openrois_avatar.engines.sculpt.head import EYE, EYE_RADIUS, DepthMap
from openrois_avatar.engines.sculpt.lids import HALF_WIDTH, SPOKES, brow, lashes, lid_line, on_ball
from openrois_avatar.engines.sculpt.mesh import Faces, grid_faces, grid_normals
from openrois_avatar.engines.sculpt.part import Part, Shape, State, both_ways, mirrored_shape, plain, stepped, towards
from openrois_avatar.engines.sculpt.rig import turned
from openrois_avatar.engines.sculpt.shading import CLOTH, PLAIN, Surface, linear

_CONVERGENCE = 0.045
"""How far, in radians, each eye turns inwards to meet the other's gaze."""
_AHEAD = np.asarray((0.0, -1.0, 0.0))


def parts(depth: DepthMap) -> list[Part]:
    """Both eyeballs with catch-lights, lashes and brows."""
    return [
        part for side in (1, -1) for part in (_eyeball(side), _catch_lights(side), _lashes(side), _brow(depth, side))
    ]


def _gaze(pose: Pose, side: int) -> tuple[float, float]:
    yaw, pitch = stepped(pose.gaze_yaw - side * _CONVERGENCE, pose.gaze_pitch)
    return yaw, pitch


def _eyeball(side: int) -> Part:
    directions, albedo, faces = _ball()
    centre = np.asarray(EYE) * (side, 1, 1)

    def shape(pose: Pose) -> Shape:
        looking = directions @ turned(*_gaze(pose, side), 0.0).T
        shadow = _lid_shadow(looking * EYE_RADIUS * (side, 1, 1), *lid_state(pose, side))
        return Shape(centre + looking * EYE_RADIUS, looking, shadow)

    return Part(
        "eyeball",
        "head",
        faces,
        Surface(albedo, finish=PLAIN),
        shape,
        lambda pose: (*_gaze(pose, side), *lid_state(pose, side)),
    )


def _catch_lights(side: int) -> Part:
    centre = np.asarray(EYE) * (side, 1, 1)
    normals = np.tile(_AHEAD, (len(_glints(0.0, 0.0)), 1))

    def shape(pose: Pose) -> Shape:
        return Shape(centre + _glints(*_gaze(pose, side)), normals)

    surface = Surface(np.full(normals.shape, 3.0), finish=PLAIN)
    return Part("catch-lights", "head", _GLINT_FACES, surface, shape, lambda pose: _gaze(pose, side))


def _lashes(side: int) -> Part:
    rows, columns, _ = lashes(0.0, 0.0, 0.0).shape
    normals = np.tile(_AHEAD, (rows * columns, 1))

    def shape(pose: Pose) -> Shape:
        return mirrored_shape(Shape(lashes(*lid_state(pose, side)).reshape(-1, 3), normals), side)

    faces = both_ways(grid_faces(rows, columns, closed=False))
    return Part(
        "lashes", "head", faces, plain(palette.LASH, rows * columns, PLAIN), shape, lambda pose: lid_state(pose, side)
    )


def _brow(depth: DepthMap, side: int) -> Part:
    rows, columns, _ = brow(depth, 0.0, 0.0).shape

    def state(pose: Pose) -> State:
        return stepped(pose.brow_left if side > 0 else pose.brow_right, pose.frown)

    def shape(pose: Pose) -> Shape:
        lift, frown = state(pose)
        grid = brow(depth, lift, frown)
        normals = towards(grid_normals(grid, closed=False), _AHEAD)
        return mirrored_shape(Shape(grid.reshape(-1, 3), normals.reshape(-1, 3)), side)

    faces = both_ways(grid_faces(rows, columns, closed=False))
    return Part("brow", "head", faces, plain(palette.BROW, rows * columns, CLOTH), shape, state)


_BALL_RINGS = np.radians([0, 5, 9, 12, 13.5, 16, 20, 25, 29, 31, 32.5, 37, 46, 58, 72, 86, 98, 108])
_BALL_SPOKES = 36


def _ball() -> tuple[Array, Array, Faces]:
    """Directions (n, 3) from the eye's centre when it looks ahead, their albedo (n, 3), and the faces."""
    turn = np.arange(_BALL_SPOKES) * 2 * np.pi / _BALL_SPOKES
    ring = _BALL_RINGS[:, None]
    directions = np.stack([np.sin(ring) * np.cos(turn), -np.cos(ring) + 0 * turn, np.sin(ring) * np.sin(turn)], axis=-1)
    iris, dark, bright = linear(palette.IRIS), linear(palette.IRIS_DARK), linear(palette.IRIS_BRIGHT)
    random = np.random.default_rng(3)
    streaks = 1 + 0.22 * random.normal(size=_BALL_SPOKES)[:, None]
    # Light from above leaves the iris through its lower half, which is what makes an eye look deep.
    low = np.clip(0.5 - np.sin(turn), 0, 1.5)[:, None] / 1.5
    rows = []
    for angle in np.degrees(_BALL_RINGS):
        if angle < 13:
            colour = np.tile(np.asarray((0.004, 0.006, 0.008)), (_BALL_SPOKES, 1))
        elif angle < 31:
            depth = (angle - 13) / 17
            glow = np.clip(1.25 - abs(depth - 0.45) * 2.2, 0, 1)
            colour = (dark * (1 - glow) + (iris * (1 - low * 0.75) + bright * low * 0.75) * glow) * streaks
        elif angle < 32:
            colour = np.tile(dark * 0.8, (_BALL_SPOKES, 1))
        else:
            colour = np.tile(linear(palette.SCLERA) * (0.86 if angle < 34 else 1.0), (_BALL_SPOKES, 1))
        rows.append(np.clip(colour, 0, 1))
    faces = grid_faces(len(_BALL_RINGS), _BALL_SPOKES, True)[:, ::-1]
    return directions.reshape(-1, 3), np.concatenate(rows), faces


def _lid_shadow(offsets: Array, lid: float, squint: float, wide: float) -> Array:
    """Openness (n,) of the eyeball's surface at offsets (n, 3) from its centre: the upper lid shades it."""
    line_x, line_z = lid_line(lid, squint, wide)
    half = SPOKES // 2 + 1
    upper = np.interp(offsets[:, 0], line_x[:half][::-1], line_z[:half][::-1])
    lower = np.interp(offsets[:, 0], line_x[half - 1 :], line_z[half - 1 :])
    under = np.clip((upper - offsets[:, 2]) / 0.10, 0, 1)
    over = np.clip((offsets[:, 2] - lower) / 0.05, 0, 1)
    corner = np.clip((HALF_WIDTH - np.abs(offsets[:, 0])) / 0.09, 0, 1)
    return np.asarray((0.30 + 0.70 * under) * (0.75 + 0.25 * over) * (0.70 + 0.30 * corner))


_GLINT_SPOKES = 12
_GLINTS = ((-0.052, 0.062, 0.036), (0.050, -0.056, 0.016))


def _fan(start: int) -> list[tuple[int, int, int]]:
    return [(start, start + 1 + (k + 1) % _GLINT_SPOKES, start + 1 + k) for k in range(_GLINT_SPOKES)]


_GLINT_FACES: Faces = np.asarray(
    [face for n in range(len(_GLINTS)) for face in _fan(n * (_GLINT_SPOKES + 1))], np.int32
)[:, ::-1]


def _glints(yaw: float, pitch: float) -> Array:
    """The catch-lights as small discs, offsets (n, 3) from the eye's centre; they follow the gaze only in part."""
    x, z = 0.75 * EYE_RADIUS * np.sin(yaw), 0.75 * EYE_RADIUS * np.sin(pitch)
    turn = np.arange(_GLINT_SPOKES) * 2 * np.pi / _GLINT_SPOKES
    points = []
    for across, up, size in _GLINTS:
        disc = np.stack([across + x + size * np.cos(turn), up + z + size * np.sin(turn)], axis=1)
        flat = np.concatenate([[[across + x, up + z]], disc])
        points.append(np.stack([flat[:, 0], -on_ball(flat[:, 0], flat[:, 1], EYE_RADIUS + 0.012), flat[:, 1]], axis=1))
    return np.concatenate(points)
