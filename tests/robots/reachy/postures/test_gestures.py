"""The key-framed reactions."""

import pytest
from openrois_robots.reachy.postures.follower import Follower
from openrois_robots.reachy.postures.gestures import GESTURES, SLEEPING, Frame, turned
from openrois_robots.reachy.postures.limits import STEP, MotionLimits
from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL


@pytest.mark.parametrize("name", GESTURES)
def test_a_gesture_is_within_reach_ends_in_a_known_posture_and_takes_a_few_seconds(name: str) -> None:
    frames = GESTURES[name]
    assert all(frame.posture == frame.posture.within_reach() and 0 < frame.pace <= 1 for frame in frames)
    assert frames[-1].posture == (ASLEEP if name == SLEEPING else NEUTRAL)
    follower, steps = Follower(MotionLimits()), 0
    for frame in frames:
        steps += int(frame.hold / STEP)
        while not follower.is_at(frame.posture):
            follower.step(frame.posture, frame.pace)
            steps += 1
    assert 0.5 < steps * STEP < 6


def test_a_gesture_is_played_where_the_body_is_turned() -> None:
    assert turned(Frame(ASLEEP, 1.0, 0.5), 0.7).posture.body == 0.7
    assert turned(Frame(ASLEEP, 1.0, 0.5), 0.7).pace == 0.5
