from itertools import pairwise

import pytest
from openrois_avatar.engines.animation.gait import Steps
from openrois_avatar.engines.animation.pose import Pose, channels

FRAME = 1 / 60


def walked(
    steps: Steps, seconds: float, ahead: float = 0.0, left: float = 0.0, turn: float = 0.0
) -> list[dict[str, float]]:
    seen = []
    for _ in range(round(seconds / FRAME)):
        steps.advance(ahead, left, turn, FRAME)
        seen.append(dict(steps.channels()))
    return seen


def test_standing_figure_takes_no_steps() -> None:
    steps = Steps()
    assert walked(steps, 1.0) == [{}] * 60
    assert steps.effort == 0.0


def test_legs_and_arms_swing_against_each_other() -> None:
    seen = walked(Steps(), 4.0, ahead=1.0)[60:]
    assert set(seen[0]) <= set(channels(Pose()))
    right, left = ([pose[f"{side}_leg.hip"] for pose in seen] for side in ("right", "left"))
    assert max(right) > 0.3
    assert min(right) < -0.3
    for pose in seen:
        if abs(pose["right_leg.hip"] - pose["left_leg.hip"]) > 0.3:
            forward = pose["right_leg.hip"] > pose["left_leg.hip"]
            # Ahead is towards the viewer, where y is small.
            assert (pose["right.y"] > pose["left.y"]) == forward
    assert max(pose["left_leg.knee"] for pose in seen) > 0.6
    assert min(pose["left_leg.knee"] for pose in seen) < 0.15
    assert max(left) == pytest.approx(max(right), abs=0.05)


def test_steps_are_as_long_as_the_way() -> None:
    def strides(ahead: float) -> int:
        hips = [pose["right_leg.hip"] for pose in walked(Steps(), 10.0, ahead=ahead)[60:]]
        return sum(before < 0 <= after for before, after in pairwise(hips))

    assert 8 <= strides(1.0) <= 10
    assert strides(0.5) < strides(1.0) < strides(2.0)


def test_backwards_is_the_other_way_round() -> None:
    ahead, back = walked(Steps(), 1.0, ahead=0.5), walked(Steps(), 1.0, ahead=-0.5)
    assert [round(pose["right_leg.hip"], 9) for pose in ahead] != [round(pose["right_leg.hip"], 9) for pose in back]
    assert back[30]["right_leg.knee"] != ahead[30]["right_leg.knee"]


def test_a_turn_on_the_spot_takes_small_steps() -> None:
    seen = walked(Steps(), 2.0, turn=2.0)[60:]
    assert max(pose["left_leg.knee"] for pose in seen) > 0.1
    assert max(abs(pose["left_leg.hip"]) for pose in seen) < 0.12


def test_nothing_jumps_when_it_starts_and_stops_and_it_comes_to_rest() -> None:
    steps = Steps()
    seen = walked(steps, 2.0, ahead=1.5) + walked(steps, 1.0) + walked(steps, 1.0, left=0.4)
    names = {name for pose in seen for name in pose}
    for before, after in pairwise(seen):
        for name in names:
            assert abs(after.get(name, 0.0) - before.get(name, 0.0)) < 0.3, name
    assert walked(steps, 1.0)[-1] == {}
