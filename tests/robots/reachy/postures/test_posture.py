"""Postures of a Reachy Mini, and the matrix by which its daemon knows them."""

from math import cos, isclose, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL, RANGES, Posture, angle_between, apart, turned_away

POSTURES = st.builds(Posture, *(st.floats(low, high) for low, high in RANGES))


def rows(posture: Posture) -> list[list[float]]:
    return [posture.matrix[row : row + 4] for row in range(0, 16, 4)]


@given(POSTURES)
def test_a_posture_is_the_same_after_its_matrix(posture: Posture) -> None:
    read = Posture.from_matrix(rows(posture), posture.body, posture.antennas)
    assert read.numbers == pytest.approx(posture.numbers, abs=1e-9)


def test_the_daemons_neutral_pose_is_the_identity() -> None:
    assert NEUTRAL.matrix == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def test_a_head_that_looks_to_the_left_down_and_leans_has_the_matrix_of_these_turns() -> None:
    assert Posture(yaw=0.3).rotation == (
        pytest.approx((cos(0.3), -sin(0.3), 0)),
        pytest.approx((sin(0.3), cos(0.3), 0)),
        (0, 0, 1),
    )
    assert Posture(pitch=0.3).rotation[2] == pytest.approx((-sin(0.3), 0, cos(0.3)))
    assert Posture(roll=0.3).rotation[2] == pytest.approx((0, sin(0.3), cos(0.3)))


@pytest.mark.parametrize("wrong", [float("nan"), float("inf")])
def test_what_is_no_number_is_no_posture(wrong: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        Posture.from_matrix(rows(NEUTRAL), 0.0, [0.0, wrong])
    with pytest.raises(ValueError, match="finite"):
        Posture.from_matrix([[wrong] * 4] * 4, 0.0, [0.0, 0.0])


def test_the_head_turns_with_the_body_and_is_shifted_in_its_axes() -> None:
    posture = Posture(yaw=0.2, x=0.02, body=1.0)
    assert posture.rotation[0][0] == pytest.approx(cos(1.2))
    assert (posture.matrix[3], posture.matrix[7]) == pytest.approx((0.02 * cos(1), 0.02 * sin(1)))


def test_asleep_is_the_pose_that_the_daemon_calls_so() -> None:
    told = [[0.911, 0.004, 0.413], [-0.004, 1.0, -0.001], [-0.413, -0.001, 0.911]]
    for row, expected in zip(ASLEEP.rotation, told, strict=True):
        assert row == pytest.approx(expected, abs=0.005)
    assert ASLEEP.matrix[11] == -0.044


def test_what_is_out_of_reach_becomes_the_nearest_posture() -> None:
    far = Posture(roll=-9, pitch=9, yaw=9, z=-9, body=-9, left=9)
    assert far.within_reach() == Posture(-0.5, 0.6, 1.0, 0, 0, -0.055, -2.7, -0.1745, 3.1)


@given(POSTURES, POSTURES)
def test_differences_are_angles_and_the_same_both_ways(one: Posture, other: Posture) -> None:
    assert 0 <= angle_between(one, other) <= turned_away(one, other) <= apart(one, other)
    assert isclose(apart(one, other), apart(other, one), abs_tol=1e-9)
    assert apart(one, one) < 1e-6


def test_an_antenna_and_a_shifted_head_are_differences() -> None:
    assert apart(NEUTRAL, Posture(left=1.1745)) == pytest.approx(1)
    assert apart(NEUTRAL, Posture(z=-0.05)) == pytest.approx(0.5)
    assert turned_away(NEUTRAL, Posture(body=0.3)) == pytest.approx(0.3)
