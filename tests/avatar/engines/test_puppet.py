import importlib.util
import subprocess
import sys
from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest
from openrois_avatar.engines import palette, puppet
from openrois_avatar.engines.animation.animator import Animator
from openrois_avatar.engines.animation.gait import Steps
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.animation.visemes import SHAPES
from openrois_avatar.engines.puppet.canvas import colour
from openrois_avatar.engines.puppet.stage import Stage
from openrois_avatar.engines.room.scene import OtherFigure, Scene
from openrois_avatar.engines.room.shot import shot
from openrois_avatar.engines.runner import still_pose
from openrois_avatar.engines.settings import Picture, Pixels
from openrois_avatar.link.messages import Place

pytestmark = pytest.mark.extra(name="puppet")

REST = still_pose()
EYES = np.s_[118:160, 262:376]
MOUTH = np.s_[160:202, 280:352]
SIZE = Picture()


@cache
def stage() -> Stage:
    return Stage(SIZE)


def drawn(pose: Pose) -> Any:
    """The picture's blue, green and red, (360, 640, 3), as numbers that can be subtracted."""
    return stage().draw(pose)[:, :, :3].astype(int)


def difference(one: Any, other: Any) -> float:
    return float(np.abs(one - other).mean())


def near(picture: Any, code: str, distance: int = 30) -> int:
    """How many pixels have nearly a colour."""
    return int((np.abs(picture - np.asarray(colour(code)[::-1])).max(axis=-1) <= distance).sum())


def test_a_person_in_front_of_a_quiet_backdrop() -> None:
    picture = drawn(REST)
    assert picture.shape == (360, 640, 3)
    for code, least in ((palette.JUMPER, 8_000), (palette.SKIN, 6_000), (palette.HAIR, 3_000), (palette.COLLAR, 1_200)):
        assert near(picture, code) > least, code
    assert near(picture[EYES], palette.IRIS) > 150
    assert difference(picture[:20, :100], picture[:20, :-101:-1]) < 1


def test_picture_of_a_pose_does_not_depend_on_earlier_pictures() -> None:
    first = drawn(REST)
    drawn(still_pose("wave", at=1.2))
    assert np.array_equal(drawn(REST), first)
    assert np.array_equal(Stage(SIZE).draw(REST)[:, :, :3], first)


@pytest.mark.parametrize(("width", "height"), [(320, 240), (854, 480)])
def test_other_sizes(width: int, height: int) -> None:
    picture: Pixels = Stage(Picture(width, height)).draw(REST)
    assert picture.shape == (height, width, 4)
    assert near(picture[:, :, :3].astype(int), palette.JUMPER) > width * height // 60


def test_every_viseme_has_its_own_mouth() -> None:
    mouths = {name: drawn(still_pose(viseme=name))[MOUTH] for name in SHAPES}
    pairs = [(one, other) for one in SHAPES for other in SHAPES if one < other]
    assert len(pairs) == 105
    assert [pair for pair in pairs if difference(mouths[pair[0]], mouths[pair[1]]) < 0.8] == []


def test_an_open_mouth_is_dark_inside_and_a_closed_one_is_not() -> None:
    assert near(drawn(still_pose(viseme="aa"))[MOUTH], palette.MOUTH_INSIDE) > 100
    assert near(drawn(still_pose(viseme="PP"))[MOUTH], palette.MOUTH_INSIDE) == 0


def test_teeth_and_tongue_show_where_speech_puts_them() -> None:
    assert near(drawn(still_pose(viseme="SS"))[MOUTH], palette.TEETH) > 30
    assert near(drawn(still_pose(viseme="FF"))[MOUTH], palette.TEETH) > 10
    assert near(drawn(still_pose(viseme="PP"))[MOUTH], palette.TEETH) == 0


def test_a_blink_covers_the_irises_and_a_wink_one_of_them() -> None:
    left_eye, right_eye = np.s_[118:160, 322:376], np.s_[118:160, 262:316]
    closed = drawn(replace(REST, lid_left=1.0, lid_right=1.0))
    assert near(closed[EYES], palette.IRIS) == 0
    assert near(closed[EYES], palette.SCLERA, 12) == 0
    wink = drawn(replace(REST, lid_left=1.0, lid_right=0.0))
    assert near(wink[left_eye], palette.IRIS) == 0
    assert near(wink[right_eye], palette.IRIS) > 80


def test_the_eyes_look_to_the_side_of_the_picture_that_is_meant() -> None:
    def irises(yaw: float) -> float:
        columns = np.nonzero(np.abs(drawn(replace(REST, gaze_yaw=yaw))[EYES] - irises_colour).max(axis=-1) <= 30)[1]
        return float(columns.mean())

    irises_colour = np.asarray(colour(palette.IRIS)[::-1])
    assert irises(0.3) - irises(-0.3) > 4


@pytest.mark.parametrize("channel", ["head_yaw", "head_pitch", "head_roll", "brow_left", "frown", "wide", "squint"])
def test_head_and_brows_follow_the_pose(channel: str) -> None:
    moved: dict[str, Any] = {channel: 0.4}
    assert difference(drawn(replace(REST, **moved))[:210], drawn(REST)[:210]) > 0.02


def test_breath_and_shoulders_move_the_jumper() -> None:
    rest = drawn(replace(REST, breath=0.0))[240:]
    assert difference(drawn(replace(REST, breath=1.0))[240:], rest) > 0.1
    assert difference(drawn(replace(REST, breath=0.0, shoulder_left=1.0))[240:], rest) > 0.5


@pytest.mark.parametrize("name", REACTIONS)
def test_every_reaction_shows_in_its_middle(name: str) -> None:
    middle = REACTIONS[name].duration * 0.45
    assert difference(drawn(still_pose(name, at=middle)), drawn(still_pose(at=middle))) > 0.4


def test_the_right_hand_is_on_the_left_of_the_picture() -> None:
    for name in ("wave", "raise_hand"):
        picture = drawn(still_pose(name, at=1.3))[:230]
        assert near(picture[:, :230], palette.SKIN) > 700
        assert near(picture[:, 410:], palette.SKIN) == 0


def test_the_watch_is_on_the_left_wrist() -> None:
    assert near(drawn(still_pose("glance_at_watch", at=1.3))[280:], palette.WATCH, 12) > 40
    shrug = drawn(still_pose("shrug", at=0.9))[250:]
    assert near(shrug[:, 400:], palette.WATCH, 12) > 40
    assert near(shrug[:, :240], palette.WATCH, 12) == 0


def test_both_hands_meet_in_a_clap() -> None:
    front = np.s_[230:330, 270:370]
    assert near(drawn(still_pose("clap", at=1.06))[front], palette.SKIN) > near(drawn(REST)[front], palette.SKIN) + 600


def at(x: float, y: float, heading: float, share: float, visitor: OtherFigure | None = None) -> Scene:
    return Scene(Place(x, y, heading), visitor, shot(0.0, 0.0, share))


def seen(pose: Pose, scene: Scene) -> Any:
    return stage().draw(pose, scene)[:, :, :3].astype(int)


def columns(picture: Any, code: str, distance: int = 30) -> float:
    """Where nearly a colour is from left to right, on average."""
    return float(np.nonzero(np.abs(picture - np.asarray(colour(code)[::-1])).max(axis=-1) <= distance)[1].mean())


def test_from_afar_the_whole_figure_is_seen_where_it_is() -> None:
    left, right = (seen(REST, at(x, 0.0, -pi / 2, 1.0)) for x in (-1.0, 1.0))
    assert columns(right, palette.JUMPER) - columns(left, palette.JUMPER) > 150
    for picture in (left, right):
        assert near(picture, palette.FLOOR) > 20_000
        assert 100 < near(picture, palette.JUMPER) < 4_000
        assert near(picture, palette.SHOES, 20) > 10
    near_one, far_one = (near(seen(REST, at(0.0, y, -pi / 2, 1.0)), palette.JUMPER) for y in (-0.7, 2.5))
    assert near_one > 1.4 * far_one


def test_a_figure_that_goes_away_shows_its_back() -> None:
    front, back = (seen(REST, at(0.0, 0.0, heading, 0.6)) for heading in (-pi / 2, pi / 2))
    face = np.s_[40:160, 270:370]
    assert near(front[face], palette.SKIN) > near(back[face], palette.SKIN) + 300
    assert near(back, palette.HAIR) > near(front, palette.HAIR)
    aside = seen(REST, at(0.0, 0.0, 0.0, 0.6))
    assert difference(aside, front) > 0.5


def test_legs_step_and_hands_wave_while_it_walks() -> None:
    steps = Steps()
    for _ in range(60):
        steps.advance(0.9, 0.0, 0.0, 1 / 60)
    scene = at(0.0, 0.0, -0.4, 0.6)
    standing = seen(REST, scene)
    walking = seen(Animator(1).pose(10.0, steps.channels()), scene)
    assert difference(walking[250:], standing[250:]) > 1.0
    assert difference(seen(still_pose("wave", at=1.2), scene)[:230], standing[:230]) > 0.5


def test_the_visitor_and_the_furniture_are_seen_where_they_are() -> None:
    people = [OtherFigure(Place(x, 1.0, heading)) for x, heading in ((-1.5, -pi / 2), (1.0, pi / 2))]
    left, right = (seen(REST, at(0.0, 0.0, -pi / 2, 1.0, other)) for other in people)
    alone = seen(REST, at(0.0, 0.0, -pi / 2, 1.0))
    assert columns(right[:200], palette.VISITOR_HAIR, 8) - columns(left[:200], palette.VISITOR_HAIR, 8) > 200
    assert near(left, palette.VISITOR_SKIN, 15) > near(alone, palette.VISITOR_SKIN, 15) + 60
    assert near(alone, palette.LEAF, 20) > 60
    assert columns(alone, palette.LEAF, 20) < 200
    # Behind the camera neither a figure nor furniture is seen.
    close = Scene(Place(0.0, 3.4, -pi / 2), OtherFigure(Place(0.0, 0.0, 0.0)), shot(0.0, 3.4, 0.0))
    assert near(seen(REST, close), palette.VISITOR_JACKET, 10) < 200
    assert stage().draw(REST, close).shape == (360, 640, 4)


def test_visitor_behind_the_figure_is_seen_in_the_close_view() -> None:
    behind = seen(REST, Scene(visitor=OtherFigure(Place(-0.8, 1.7, 0.0))))
    assert near(behind[:, :230], palette.VISITOR_JACKET) > 2_000
    assert np.array_equal(behind[100:200, 260:380], drawn(REST)[100:200, 260:380])


def test_missing_library_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    assert puppet.available() == (True, "")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert puppet.available() == (False, "pygame-ce is not installed: pip install 'openrois[puppet]'")


@pytest.mark.engine
def test_asking_whether_it_runs_does_not_import_pygame() -> None:
    code = f"import sys; from {puppet.__name__} import available; available(); sys.exit('pygame' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=20, check=False).returncode == 0


def test_smaller_pictures_show_the_same() -> None:
    resized = Stage(SIZE)
    resized.resize(Picture(320, 180))
    assert np.array_equal(resized.draw(REST), Stage(Picture(320, 180)).draw(REST))
