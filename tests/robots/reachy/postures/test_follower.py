"""The way to a goal: whatever the goals are, no target is far from the last one, and a goal that stays is reached."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_robots.reachy.postures.follower import Follower
from openrois_robots.reachy.postures.limits import STEP, MotionLimits
from openrois_robots.reachy.postures.posture import NEUTRAL, RANGES, Posture, angle_between

LIMITS = st.builds(MotionLimits, st.floats(0.1, 1.5), st.floats(0.1, 1.0), st.floats(0.1, 2.4))
GOALS = st.builds(Posture, *(st.floats(1.5 * low, 1.5 * high) for low, high in RANGES))


@given(LIMITS, st.lists(st.tuples(GOALS, st.integers(1, 40), st.floats(0.1, 1)), max_size=8))
@settings(max_examples=80, deadline=None)
def test_no_target_is_far_from_the_last_one_whatever_the_goals_do(
    limits: MotionLimits, goals: list[tuple[Posture, int, float]]
) -> None:
    follower = Follower(limits)
    for goal, steps, pace in goals:
        for _ in range(steps):
            before, now = follower.posture, follower.step(goal, pace)
            # Two of them fall into one control step of the daemon at the most.
            assert angle_between(before, now) < 0.05
            assert abs(now.body - before.body) <= limits.body * STEP + 1e-6
            for one, other in zip(before.antennas, now.antennas, strict=True):
                assert abs(one - other) <= limits.antennas * STEP + 1e-6
            for value, (low, high) in zip(now.numbers, RANGES, strict=True):
                assert low <= value <= high


@given(LIMITS, GOALS, st.integers(0, 50), GOALS)
@settings(max_examples=40, deadline=None)
@pytest.mark.long
def test_a_goal_that_stays_is_reached_and_the_robot_stands_there(
    limits: MotionLimits, first: Posture, steps: int, last: Posture
) -> None:
    follower = Follower(limits)
    for _ in range(steps):
        follower.step(first)
    for _ in range(int(200 / STEP)):
        if follower.is_at(last):
            break
        follower.step(last)
    assert follower.is_at(last)
    assert follower.step(last) == last.within_reach()


@given(GOALS, st.integers(0, 60))
@settings(max_examples=40, deadline=None)
def test_a_robot_that_is_to_rest_stands_within_a_fifth_of_a_second(goal: Posture, steps: int) -> None:
    follower = Follower(MotionLimits())
    for _ in range(steps):
        follower.step(goal)
    rest = follower.rest()
    for _ in range(int(0.2 / STEP)):
        follower.step(rest)
    before = follower.posture
    assert angle_between(before, follower.step(rest)) < 0.002


def test_all_numbers_of_a_posture_arrive_together_from_standing() -> None:
    follower, goal = Follower(MotionLimits()), Posture(roll=0.3, yaw=-0.6, body=1.0, left=2.0)
    while not follower.is_at(goal):
        now = follower.step(goal)
        shares = [now.roll / 0.3, now.yaw / -0.6, now.body, (now.left - 0.1745) / (2.0 - 0.1745)]
        assert max(shares) - min(shares) < 1e-6


def test_it_goes_on_from_where_the_robot_is_put() -> None:
    follower = Follower(MotionLimits())
    follower.step(Posture(yaw=1.0))
    assert not follower.is_still
    follower.restart(NEUTRAL)
    assert follower.is_still
    assert follower.is_at(NEUTRAL)
