"""The limits of a Kachaka in its configuration."""

import pytest
from openrois_robots.kachaka.limits import ANGULAR, LINEAR, DrivingLimits, SpeechSettings, normalised


@pytest.mark.parametrize(("speed", "turn"), [(0.05, 0.05), (LINEAR, ANGULAR)])
def test_limits_within_those_of_the_robot_are_taken(speed: float, turn: float) -> None:
    assert DrivingLimits(speed, turn) == DrivingLimits(speed=speed, turn=turn)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"speed": 0.31}, r"driving\.speed must be between 0\.05 and 0\.3, not 0\.31"),
        ({"speed": 0.0}, r"driving\.speed must be between"),
        ({"turn": 1.6}, r"driving\.turn must be between 0\.05 and 1\.57, not 1\.6"),
    ],
)
def test_others_are_refused(wrong: dict[str, float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        DrivingLimits(**wrong)


def test_speech_is_asked_for_or_refused_and_nothing_else() -> None:
    assert SpeechSettings().while_driving == "ask"
    assert SpeechSettings("refuse").while_driving == "refuse"
    with pytest.raises(ValueError, match=r"speech\.while_driving must be ask or refuse, not 'wait'"):
        SpeechSettings("wait")


@pytest.mark.parametrize(
    ("asked", "sent"),
    [
        ((0.3, 1.57), (1.0, 1.0)),
        ((-0.15, 0.0), (-0.5, 0.0)),
        ((9.0, -9.0), (1.0, -1.0)),
        ((-9.0, 9.0), (-1.0, 1.0)),
    ],
)
def test_velocities_are_normalised(asked: tuple[float, float], sent: tuple[float, float]) -> None:
    assert normalised(*asked, DrivingLimits()) == pytest.approx(sent)


def test_a_lower_limit_holds() -> None:
    assert normalised(0.3, -1.57, DrivingLimits(0.1, 0.5)) == pytest.approx((0.1 / 0.3, -0.5 / 1.57))


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf")])
def test_a_velocity_that_is_no_number_is_none(number: float) -> None:
    assert normalised(number, 0.5, DrivingLimits()) == (0.0, 0.0)
    assert normalised(0.1, number, DrivingLimits()) == (0.0, 0.0)
