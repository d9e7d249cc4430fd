"""The figure: its parts follow the pose."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from openrois_avatar.engines.animation.pose import Arm, Leg, Mouth, Pose
from openrois_avatar.engines.animation.visemes import SHAPES
from openrois_avatar.engines.figure import arms, figure
from openrois_avatar.engines.figure.baked import read
from openrois_avatar.engines.figure.head import EYE, EYE_RADIUS, MOUTH
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.mouth import BORDER, INSIDE, RINGS, SPOKES
from openrois_avatar.engines.figure.part import Part
from openrois_avatar.engines.figure.rig import ANKLE, HIP, KNEE, Space, standing


@pytest.fixture(scope="module")
def parts() -> list[Part]:
    return figure.build()


def named(parts: list[Part], name: str) -> Part:
    return next(part for part in parts if part.name == name)


def outwards(part: Part) -> float:
    """The share of a part's faces whose winding agrees with its normals."""
    shape = part.shape(Pose())
    a, b, c = (shape.vertices[part.faces[:, corner]] for corner in range(3))
    area = np.cross(b - a, c - a)
    seen = np.linalg.norm(area, axis=1) > 1e-7
    return float((np.einsum("ij,ij->i", area, shape.normals[part.faces[:, 0]])[seen] > 0).mean())


def vertices(parts: list[Part], name: str, pose: Pose) -> Array:
    return named(parts, name).shape(pose).vertices


BUSY = Pose(
    head_yaw=0.3,
    gaze_yaw=0.2,
    lid_left=0.5,
    lid_right=1.0,
    brow_left=0.7,
    frown=0.4,
    breath=0.8,
    shoulder_left=0.9,
    mouth=Mouth(jaw=0.8, round=0.5, tongue=1.0),
    left=Arm(z=-1.0, y=-0.8, curl=0.9, spread=0.8),
)


@pytest.mark.parametrize("pose", [Pose(), BUSY])
def test_every_part_is_a_sound_mesh_in_every_pose(parts: list[Part], pose: Pose) -> None:
    for part in parts:
        shape = part.shape(pose)
        count = len(shape.vertices)
        assert shape.normals.shape == shape.vertices.shape == part.surface.albedo.shape, part.name
        assert np.isfinite(shape.vertices).all(), part.name
        assert np.isfinite(shape.normals).all(), part.name
        assert 0 <= part.faces.min() <= part.faces.max() < count < 65536, part.name
        assert shape.openness is None or shape.openness.shape == (count,)


def test_solid_parts_are_seen_from_outside(parts: list[Part]) -> None:
    for part in parts:
        if part.name in {
            "hair",
            "skull",
            "ear",
            "eyeball",
            "lid",
            "lips",
            "neck",
            "jumper",
            "hand",
            "watch",
            "hips",
            "thigh",
            "shin",
            "foot",
        }:
            assert outwards(part) > 0.9, part.name


def test_the_whole_figure_is_small_enough_for_a_software_renderer(parts: list[Part]) -> None:
    close = figure.visible(Pose())
    assert sum(len(part.faces) for part in parts if close[part.space]) < 36_000
    assert sum(len(part.faces) for part in parts) < 54_000


def test_parts_that_depend_on_nothing_never_change(parts: list[Part]) -> None:
    still = [part for part in parts if part.state(Pose()) == ()]
    assert {"hair", "collar", "ear"} <= {part.name for part in still}
    for part in still:
        assert part.shape(BUSY).vertices is part.shape(Pose()).vertices


def test_the_same_state_gives_the_same_shape(parts: list[Part]) -> None:
    almost = replace(BUSY, head_yaw=BUSY.head_yaw + 1e-6, mouth=replace(BUSY.mouth, jaw=BUSY.mouth.jaw + 1e-6))
    for part in parts:
        if part.state(almost) == part.state(BUSY):
            assert part.shape(almost).vertices == pytest.approx(part.shape(BUSY).vertices, abs=1e-3), part.name


def lips(parts: list[Part], viseme: str) -> Array:
    return np.concatenate([vertices(parts, name, Pose(mouth=SHAPES[viseme])) for name in ("lips", "tongue")])


def test_every_viseme_shapes_the_mouth_in_its_own_way(parts: list[Part]) -> None:
    shapes = {viseme: lips(parts, viseme) for viseme in SHAPES}
    for first, second in combinations(shapes, 2):
        # A hundredth of a decimetre is about one pixel of the picture.
        assert np.abs(shapes[first] - shapes[second]).max() > 0.01, (first, second)


def opening(parts: list[Part], viseme: str) -> float:
    """Between the lips in the middle of the mouth, in dm."""
    points = vertices(parts, "lips", Pose(mouth=SHAPES[viseme])).reshape(-1, 60, 3)[3]
    return float(points[15, 2] - points[45, 2])


def width(parts: list[Part], viseme: str) -> float:
    return float(np.ptp(vertices(parts, "lips", Pose(mouth=SHAPES[viseme])).reshape(-1, 60, 3)[3, :, 0]))


def test_mouths_open_close_and_purse_as_they_should(parts: list[Part]) -> None:
    assert opening(parts, "sil") < 0.01
    assert opening(parts, "PP") < 0.01
    assert opening(parts, "aa") > opening(parts, "E") > opening(parts, "ih") > opening(parts, "sil")
    assert width(parts, "ou") < width(parts, "oh") < width(parts, "aa") < width(parts, "ih")


def test_the_skin_around_the_mouth_meets_the_face_in_every_shape(parts: list[Part]) -> None:
    for viseme in SHAPES:
        pose = Pose(mouth=SHAPES[viseme])
        border = vertices(parts, "lips", pose).reshape(-1, 60, 3)[-1]
        skull = vertices(parts, "skull", pose)
        gaps = np.linalg.norm(border[:, None] - skull[None], axis=2).min(axis=1)
        assert gaps.max() < 0.06, viseme


def gap(parts: list[Part], lid: float) -> float:
    """The widest opening between the lids of the left eye, in dm."""
    grid = vertices(parts, "lid", Pose(lid_left=lid, lid_right=lid)).reshape(-1, 48, 3)
    return float((grid[1, 1:24, 2] - grid[1, :24:-1, 2]).max())


@pytest.mark.parametrize("shape", list(SHAPES.values()), ids=list(SHAPES))
def test_the_skin_beside_the_corners_of_the_mouth_is_lit_as_the_face_is(parts: list[Part], shape: Mouth) -> None:
    lips = named(parts, "lips").shape(Pose(mouth=shape))
    face = next(piece for piece in read("avatar") if piece.name == "lips").arrays["skin_normals"]
    normals = lips.normals.reshape(RINGS, SPOKES, 3)
    across = np.abs(np.cos(np.arange(SPOKES) * 2 * np.pi / SPOKES))
    beside = (slice(BORDER + 2, None), across > 0.8)
    assert np.einsum("ijk,ijk->ij", normals[beside], face[beside]).min() > 0.98


@pytest.mark.parametrize("shape", list(SHAPES.values()), ids=list(SHAPES))
def test_the_face_leaves_room_for_lips_of_every_shape(parts: list[Part], shape: Mouth) -> None:
    pose = Pose(mouth=shape)
    skull = named(parts, "skull")
    corners = skull.shape(pose).vertices[skull.faces]
    corners = corners[(corners[:, :, 1] < -0.25).all(axis=1)]
    red = vertices(parts, "lips", pose).reshape(RINGS, SPOKES, 3)[INSIDE : BORDER + 1].reshape(-1, 3)
    assert not within(red[:, (0, 2)], corners[:, :, (0, 2)]).any()


def within(points: Array, triangles: Array) -> Array:
    """Which points (n, 2) lie within any of the triangles (m, 3, 2)."""
    sides = []
    for first in range(3):
        start, end = triangles[:, first], triangles[:, (first + 1) % 3]
        along, there = (end - start)[None], points[:, None] - start[None]
        sides.append(along[..., 0] * there[..., 1] - along[..., 1] * there[..., 0])
    turns: Array = np.stack(sides)
    return np.asarray(np.any(np.all(turns >= 0, axis=0) | np.all(turns <= 0, axis=0), axis=1))


def test_neck_and_nape_are_one_skin(parts: list[Part]) -> None:
    neck, nape = named(parts, "neck"), named(parts, "nape")
    for pose in (Pose(), Pose(head_yaw=0.5, head_pitch=0.2)):
        shown = {tuple(row) for row in np.round(neck.shape(pose).vertices, 9)}
        edge = [index for index, row in enumerate(np.round(nape.shape(pose).vertices, 9)) if tuple(row) in shown]
        assert len(edge) > 8
        front = {
            tuple(row): normal
            for row, normal in zip(np.round(neck.shape(pose).vertices, 9), neck.shape(pose).normals, strict=True)
        }
        for index in edge:
            row = tuple(np.round(nape.shape(pose).vertices[index], 9))
            assert np.allclose(front[row], nape.shape(pose).normals[index])


def test_no_skin_shows_through_the_back_of_the_jumper(parts: list[Part]) -> None:
    for name in ("neck", "nape"):
        points = vertices(parts, name, Pose())
        behind = points[(points[:, 1] > 0.3) & (points[:, 2] < -1.32)]
        assert len(behind) == 0, name
    cloth = vertices(parts, "jumper", Pose())
    # Where there was a hole under the collar there is cloth.
    there = (np.abs(cloth[:, 0]) < 0.15) & (cloth[:, 1] > 0.6) & (cloth[:, 2] < -1.25) & (cloth[:, 2] > -1.6)
    assert there.sum() >= 4


def test_a_blink_closes_the_lids(parts: list[Part]) -> None:
    assert gap(parts, 0.0) > 0.2
    assert gap(parts, 0.5) < gap(parts, 0.0)
    assert gap(parts, 1.0) < 0.01


@pytest.mark.parametrize("lid", [0.0, 0.3, 0.6, 1.0])
def test_lids_stay_outside_of_the_eyeball(parts: list[Part], lid: float) -> None:
    skin = vertices(parts, "lid", Pose(lid_left=lid, lid_right=lid)).reshape(-1, 48, 3)[1:]
    assert np.linalg.norm(skin - np.asarray(EYE), axis=2).min() > EYE_RADIUS


def test_looking_down_lowers_the_lids_and_aside_turns_the_eyes(parts: list[Part]) -> None:
    def top(pitch: float) -> float:
        return float(vertices(parts, "lid", Pose(gaze_pitch=pitch)).reshape(-1, 48, 3)[1, 12, 2])

    assert top(-0.3) < top(0.0) < top(0.3)
    ahead, aside = (vertices(parts, "eyeball", Pose(gaze_yaw=yaw)) for yaw in (0.0, 0.3))
    assert aside[0, 0] > ahead[0, 0] + 0.05


def test_brows_rise_and_frown(parts: list[Part]) -> None:
    def middle(pose: Pose) -> Array:
        return np.asarray(vertices(parts, "brow", pose).mean(axis=0))

    assert middle(Pose(brow_left=1.0))[2] > middle(Pose())[2] + 0.04
    assert middle(Pose(frown=1.0))[2] < middle(Pose())[2]


def test_breath_moves_the_chest_and_only_the_chest(parts: list[Part]) -> None:
    before, after = (vertices(parts, "jumper", Pose(breath=breath)) for breath in (0.0, 1.0))
    assert 0.02 < np.abs(after - before).max() < 0.1
    assert vertices(parts, "skull", Pose(breath=1.0)) == pytest.approx(vertices(parts, "skull", Pose()))


@pytest.mark.parametrize("arm", [Arm(), Arm(out=2.2, y=-0.5, z=-0.8), Arm(out=0.0, y=-1.1, z=-2.1, swivel=-0.9)])
def test_an_arm_keeps_its_lengths_and_reaches_its_wrist(arm: Arm) -> None:
    chain = arms.solve(arm, 0.0)
    assert np.linalg.norm(chain.elbow - chain.shoulder) == pytest.approx(arms.UPPER_LENGTH)
    assert np.linalg.norm(chain.wrist - chain.elbow) == pytest.approx(arms.FORE_LENGTH)
    assert chain.wrist == pytest.approx([-arm.out, arm.y, arm.z], abs=1e-6)
    assert chain.hand.T @ chain.hand == pytest.approx(np.eye(3), abs=1e-9)
    assert np.linalg.det(chain.hand) == pytest.approx(1.0)


def test_an_arm_points_at_what_it_cannot_reach() -> None:
    chain = arms.solve(Arm(out=9.0, y=0.3, z=-1.9), 0.0)
    assert chain.wrist[0] < -3.5
    assert chain.elbow[2] == pytest.approx(chain.wrist[2], abs=0.2)


def test_a_raised_palm_faces_the_viewer_and_its_thumb_the_head() -> None:
    hand = arms.solve(Arm(out=2.2, y=-0.5, z=-0.8, swivel=0.3, twist=0.0), 0.0).hand
    thumb, back, fingers = hand.T
    assert fingers[2] > 0.8
    assert back[1] > 0.6
    assert thumb[0] > 0.6


def test_both_arms_are_each_others_mirror() -> None:
    frames = figure.frames(Pose(left=Arm(z=-1.0), right=Arm(z=-1.0)))
    left, right = frames["hand_left"], frames["hand_right"]
    assert left.origin * (-1, 1, 1) == pytest.approx(right.origin)
    assert np.linalg.det(left.rotation) == pytest.approx(1.0)


def test_hands_are_drawn_only_when_they_may_be_seen() -> None:
    def seen(pose: Pose) -> set[str]:
        return {space for space, is_visible in figure.visible(pose).items() if is_visible}

    assert seen(Pose()) == {"body", "head"}
    assert seen(Pose(right=Arm(z=-2.0))) == {"body", "head", "hand_right"}
    assert all(figure.visible(Pose(), whole=True).values())


def test_figure_at_home_is_where_the_close_view_expects_it() -> None:
    for space, frame in figure.frames(Pose()).items():
        at_home = figure.frames(Pose(), standing(0.0, 0.0, -np.pi / 2))[space]
        assert at_home.rotation == pytest.approx(frame.rotation)
        assert at_home.origin == pytest.approx(frame.origin)
    assert figure.frames(Pose())["hips"].origin == pytest.approx(np.zeros(3))


def test_figure_that_turns_right_looks_to_the_right_of_the_picture() -> None:
    mouth = np.asarray(MOUTH)
    frame = figure.frames(Pose(), standing(5.0, 3.0, 0.0))["head"]
    at = frame.rotation @ mouth + frame.origin
    assert at[0] > 5.5
    assert at[1] == pytest.approx(3.0, abs=0.1)


@pytest.mark.parametrize("leg", [Leg(0.4, 0.1), Leg(-0.5, 0.2, -0.3), Leg(0.2, 1.1, 0.2)])
def test_legs_keep_together_and_one_foot_on_the_floor(leg: Leg) -> None:
    frames = figure.frames(Pose(left_leg=leg))

    def joint(space: Space, at: Array) -> Array:
        return np.asarray(frames[space].rotation @ at + frames[space].origin)

    assert joint("thigh_left", HIP) == pytest.approx(joint("hips", HIP))
    assert joint("thigh_left", KNEE) == pytest.approx(joint("shin_left", KNEE))
    assert joint("shin_left", ANKLE) == pytest.approx(joint("foot_left", ANKLE))
    other = ANKLE * (-1, 1, 1)
    assert min(joint("foot_left", ANKLE)[2], joint("foot_right", other)[2]) == pytest.approx(ANKLE[2])
    # Ahead is towards the viewer.
    if leg.hip > leg.knee:
        assert joint("foot_left", ANKLE)[1] < joint("foot_right", other)[1]


def test_a_fist_is_smaller_than_an_open_hand(parts: list[Part]) -> None:
    open_, fist = (vertices(parts, "hand", Pose(left=Arm(curl=curl, spread=0.0))) for curl in (0.0, 1.0))
    assert np.ptp(fist[:, 2]) < 0.80 * np.ptp(open_[:, 2])


def test_the_head_turns_on_the_neck_and_goes_along_with_the_body() -> None:
    mouth = np.asarray(MOUTH)

    def place(pose: Pose) -> Array:
        frame = figure.frames(pose)["head"]
        return np.asarray(frame.rotation @ mouth + frame.origin)

    ahead = place(Pose())
    assert ahead == pytest.approx(mouth)
    assert place(Pose(head_yaw=0.3))[0] > 0.2
    assert place(Pose(head_pitch=0.3))[2] > ahead[2]
    assert place(Pose(head_roll=0.3))[0] < 0.1
    assert place(Pose(lean=0.4))[1] < ahead[1] - 1.5
