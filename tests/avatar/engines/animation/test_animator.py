from itertools import pairwise

import pytest
from openrois_avatar.engines.animation.animator import MAX_TRACKS, Animator, Outcome
from openrois_avatar.engines.animation.pose import Pose, channels
from openrois_avatar.engines.animation.reactions import REACTIONS
from openrois_avatar.engines.animation.visemes import SHAPES, Track

FAST = {"lid_left": 0.5, "lid_right": 0.5, "gaze_yaw": 0.3, "gaze_pitch": 0.2}
WRISTS = {f"{side}.{axis}" for side in ("left", "right") for axis in ("out", "y", "z")}


def bound(channel: str) -> float:
    """How much a channel may change from one picture to the next at 60 fps."""
    if channel.startswith("mouth."):
        return 0.45
    return 0.40 if channel in WRISTS else FAST.get(channel, 0.2)


def check_continuous(poses: list[Pose]) -> None:
    flat = [channels(pose) for pose in poses]
    for before, after in pairwise(flat):
        for channel, value in after.items():
            assert abs(value - before[channel]) < bound(channel), channel


def test_at_rest_the_avatar_lives() -> None:
    animator = Animator(seed=4)
    poses = [animator.pose(n / 60) for n in range(60 * 12)]
    check_continuous(poses)
    for channel in ("head_yaw", "head_pitch", "head_roll", "gaze_yaw", "breath", "lid_left", "side"):
        assert len({channels(pose)[channel] for pose in poses}) > 25, channel
    assert max(pose.lid_left for pose in poses) == 1.0
    assert {pose.mouth.jaw for pose in poses} == {0.0}


def test_the_same_seed_lives_the_same_life() -> None:
    assert Animator(seed=2).pose(7.3) == Animator(seed=2).pose(7.3)
    assert Animator(seed=2).pose(7.3) != Animator(seed=3).pose(7.3)


@pytest.mark.parametrize("name", REACTIONS)
def test_a_reaction_moves_the_body_and_says_when_it_is_over(name: str) -> None:
    animator, still = Animator(), Animator()
    duration = REACTIONS[name].duration
    animator.react(10.0, "a", name)
    frames = [10.0 + n / 60 for n in range(int(duration * 60) + 1)]
    check_continuous([animator.pose(time) for time in frames])
    assert animator.outcomes(10.0 + duration - 0.01) == []
    assert animator.pose(10.0 + duration / 2) != still.pose(10.0 + duration / 2)
    assert animator.outcomes(10.0 + duration) == [Outcome("a", "OK")]
    assert animator.outcomes(10.0 + duration) == []
    assert animator.pose(10.0 + duration) == still.pose(10.0 + duration)


def test_a_new_reaction_goes_on_from_where_the_body_is() -> None:
    animator, poses = Animator(), []
    names = list(REACTIONS)
    for frame in range(60 * 14):
        if frame % 25 == 0:
            animator.react(frame / 60, str(frame), names[frame // 25 % len(names)])
        poses.append(animator.pose(frame / 60))
        assert {outcome.status for outcome in animator.outcomes(frame / 60)} <= {"ABORT"}
    check_continuous(poses)


def test_a_reaction_that_is_replaced_is_aborted() -> None:
    animator = Animator()
    animator.react(0.0, "a", "wave")
    animator.react(0.5, "b", "nod")
    assert animator.outcomes(0.5) == [Outcome("a", "ABORT")]
    assert animator.outcomes(0.5 + REACTIONS["nod"].duration) == [Outcome("b", "OK")]


def test_stop_aborts_and_the_body_comes_to_rest() -> None:
    animator, still = Animator(), Animator()
    animator.react(0.0, "a", "wave")
    animator.stop(0.9, "another")
    assert animator.outcomes(0.9) == []
    raised = animator.pose(0.9).right.z
    animator.stop(0.9, "a")
    assert animator.outcomes(0.9) == [Outcome("a", "ABORT")]
    assert animator.pose(0.9).right.z == pytest.approx(raised)
    check_continuous([animator.pose(0.9 + n / 60) for n in range(90)])
    assert animator.pose(2.4).right.z == pytest.approx(still.pose(2.4).right.z, abs=0.01)
    animator.stop(2.5)
    assert animator.outcomes(2.5) == []


def test_stop_without_an_id_stops_whatever_plays() -> None:
    animator = Animator()
    animator.react(0.0, "a", "bow")
    animator.stop(0.2)
    assert animator.outcomes(0.2) == [Outcome("a", "ABORT")]


def test_an_unknown_reaction_is_an_error_and_stops_nothing() -> None:
    animator = Animator()
    animator.react(0.0, "a", "bow")
    animator.react(0.1, "b", "somersault")
    assert animator.outcomes(0.1) == [Outcome("b", "ERROR")]
    assert animator.outcomes(9.0) == [Outcome("a", "OK")]


def test_speech_moves_the_mouth_from_its_start_on() -> None:
    animator = Animator()
    animator.speak(0.0, Track(1.0, [(0.0, "aa", 1.0)], 1.0))
    assert animator.pose(0.5).mouth.jaw == 0.0
    assert animator.pose(1.5).mouth.jaw == pytest.approx(SHAPES["aa"].jaw)
    assert animator.pose(2.5).mouth.jaw == 0.0


def test_speech_never_jumps_and_is_stressed_by_head_and_brows() -> None:
    animator, silent = Animator(), Animator()
    names = list(SHAPES)
    animator.speak(0.0, Track(0.5, [(0.07 * n, names[n * 4 % 15], 1.0) for n in range(60)], 4.2))
    frames = [n / 60 for n in range(60 * 6)]
    poses = [animator.pose(time) for time in frames]
    check_continuous(poses)
    stressed = max(pose.brow_left - silent.pose(time).brow_left for pose, time in zip(poses, frames, strict=True))
    assert stressed > 0.2


def test_silence_cuts_what_plays_and_drops_what_waits() -> None:
    animator = Animator()
    animator.speak(0.0, Track(0.0, [(0.0, "aa", 1.0)], 5.0))
    animator.speak(0.0, Track(2.0, [(0.0, "ou", 1.0)], 5.0))
    animator.silence(1.0)
    assert animator.pose(1.0).mouth.jaw > 0.8
    assert animator.pose(1.1).mouth.jaw == 0.0
    assert animator.pose(3.0).mouth.round == 0.0


def test_speech_that_is_never_played_does_not_pile_up() -> None:
    animator = Animator()
    for number in range(MAX_TRACKS + 5):
        animator.speak(0.0, Track(100.0 + number, [(0.0, "aa", 1.0)], 0.9))
    assert animator.pose(100.5).mouth.jaw == 0.0
    assert animator.pose(105.5).mouth.jaw > 0.8


def test_gaze_and_reaction_and_speech_go_together() -> None:
    animator = Animator()
    animator.turn_eyes(0.0, -0.8, 0.3)
    animator.react(0.0, "a", "wave")
    animator.speak(0.0, Track(0.2, [(0.0, "oh", 1.0)], 2.0))
    poses = [animator.pose(n / 60) for n in range(180)]
    check_continuous(poses)
    assert poses[70].head_yaw < -0.1
    assert poses[70].right.z > -1.5
    assert poses[70].mouth.round > 0.6


def test_lids_stay_lids_when_everything_closes_them() -> None:
    animator = Animator()
    animator.react(0.0, "a", "bow")
    for frame in range(150):
        animator.turn_eyes(frame / 60, frame % 2 * 2 - 1, 0.0)
        assert animator.pose(frame / 60).lid_left <= 1.0
