from itertools import pairwise

import pytest
from openrois_avatar.engines.animation.idle import BLINK, blink, blink_at, breath, drift, glance

FRAMES = [n / 60 for n in range(60 * 120)]


def test_breathing_never_jumps_and_uses_the_whole_chest() -> None:
    levels = [breath(time) for time in FRAMES]
    assert min(levels) == pytest.approx(0.0, abs=1e-3)
    assert max(levels) == pytest.approx(1.0, abs=1e-3)
    assert max(abs(a - b) for a, b in pairwise(levels)) < 0.02


def test_a_blink_closes_the_lids_and_opens_them_again() -> None:
    assert blink_at(-1.0) == blink_at(0.0) == blink_at(BLINK) == blink_at(1.0) == 0.0
    assert blink_at(0.1) == 1.0


def test_blinks_are_complete_irregular_and_as_frequent_as_a_persons() -> None:
    levels = [blink(time, 1) for time in FRAMES]
    closed = [index for index, (a, b) in enumerate(pairwise(levels)) if a < 0.999 <= b]
    pauses = {round((b - a) / 60, 1) for a, b in pairwise(closed)}
    assert 24 <= len(closed) <= 48
    assert len(pauses) > 12
    assert max(abs(a - b) for a, b in pairwise(levels)) < 0.4


def test_another_seed_blinks_at_other_times() -> None:
    assert [blink(time, 1) for time in FRAMES] != [blink(time, 2) for time in FRAMES]


def test_time_may_be_negative() -> None:
    assert 0.0 <= blink(-3.0, 1) <= 1.0
    assert glance(-0.1, 1) == glance(-0.1, 1)


def test_the_eyes_rest_and_jump_in_small_steps() -> None:
    looks = [glance(time, 1) for time in FRAMES]
    steps = [abs(b[0] - a[0]) for a, b in pairwise(looks)]
    assert max(abs(yaw) for yaw, _ in looks) <= 0.085
    assert max(steps) < 0.06
    assert sum(step == 0.0 for step in steps) > len(steps) / 2
    assert len(set(looks)) > 100


def test_the_head_sways_slowly() -> None:
    drifts = [drift(time, 1) for time in FRAMES]
    assert max(abs(b.yaw - a.yaw) for a, b in pairwise(drifts)) < 0.002
    assert max(one.yaw for one in drifts) > 0.02
    assert drift(1.0, 1) != drift(1.0, 2)
