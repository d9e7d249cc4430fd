import importlib.util
import subprocess
import sys
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from openrois_avatar.engines import palette, puppet
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.animation.visemes import SHAPES
from openrois_avatar.engines.puppet.canvas import colour
from openrois_avatar.engines.puppet.stage import Stage
from openrois_avatar.engines.runner import still_pose
from openrois_avatar.engines.settings import Picture, Pixels

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


def test_one_pose_gives_one_picture_whatever_was_drawn_before() -> None:
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


def test_it_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert puppet.available() == (True, "")
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert puppet.available() == (False, "pygame-ce is not installed: pip install 'openrois[puppet]'")


@pytest.mark.engine
def test_asking_whether_it_runs_does_not_import_pygame() -> None:
    code = f"import sys; from {puppet.__name__} import available; available(); sys.exit('pygame' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=20, check=False).returncode == 0
