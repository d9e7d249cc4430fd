from itertools import pairwise

import pytest
from openrois_avatar.engines.animation.gaze import Gaze


def test_without_a_command_the_avatar_looks_ahead() -> None:
    looking = Gaze().at(3.0)
    assert (looking.head_yaw, looking.head_pitch, looking.eye_yaw, looking.eye_pitch, looking.lid) == (0, 0, 0, 0, 0)


def test_the_eyes_go_first_and_turn_back_when_the_head_has_followed() -> None:
    gaze = Gaze()
    gaze.turn_to(1.0, 1.0, 0.0)
    soon, late = gaze.at(1.12), gaze.at(3.0)
    assert soon.eye_yaw > 0.4
    assert soon.head_yaw < 0.1
    assert late.head_yaw == pytest.approx(0.62 * 0.55, abs=1e-3)
    assert late.head_yaw + late.eye_yaw == pytest.approx(0.62, abs=1e-3)


def test_up_is_up_and_left_is_left() -> None:
    gaze = Gaze()
    gaze.turn_to(0.0, -1.0, 1.0)
    looking = gaze.at(2.0)
    assert looking.head_yaw < -0.2
    assert looking.head_pitch > 0.1


def test_a_large_change_comes_with_a_blink_and_a_small_one_does_not() -> None:
    gaze = Gaze()
    gaze.turn_to(0.0, 0.1, 0.0)
    assert gaze.at(0.1).lid == 0.0
    gaze.turn_to(1.0, 1.0, 0.0)
    assert gaze.at(1.1).lid == 1.0


def test_commands_in_quick_succession_never_make_it_jump() -> None:
    gaze, path = Gaze(), []
    for frame in range(240):
        if frame % 9 == 0:
            gaze.turn_to(frame / 60, (frame * 7 % 21) / 10 - 1, (frame * 5 % 21) / 10 - 1)
        looking = gaze.at(frame / 60)
        path.append((looking.head_yaw, looking.eye_yaw + looking.head_yaw, looking.lid))
    assert max(abs(b[0] - a[0]) for a, b in pairwise(path)) < 0.03
    assert max(abs(b[1] - a[1]) for a, b in pairwise(path)) < 0.30
    assert max(abs(b[2] - a[2]) for a, b in pairwise(path)) < 0.45
