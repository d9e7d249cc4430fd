"""Poses and times of messages."""

from datetime import UTC, datetime
from math import inf, nan, pi

import pytest
from openrois_robots.ros2.robot.poses import Heard, image_time, pose_message, read_heard, stamp_seconds, yaw

from tests.support.ros_robot import message, odometry


@pytest.mark.parametrize("th", [0.0, 1.0, -2.5, pi - 0.01])
def test_a_turn_is_read_from_a_quaternion(th: float) -> None:
    sent = pose_message(1.0, 2.0, th, "map", 12.5)
    assert yaw(message(**sent["pose"]["orientation"])) == pytest.approx(th)
    assert sent["header"] == {"stamp": {"sec": 12, "nanosec": 500_000_000}, "frame_id": "map"}
    assert (sent["pose"]["position"]["x"], sent["pose"]["position"]["y"]) == (1.0, 2.0)


def test_a_pose_has_its_frame_and_its_time() -> None:
    heard = read_heard(odometry(1.0, 2.0, 0.5, at=1_700_000_000.5))
    assert heard is not None
    assert (heard.x, heard.y, heard.frame) == (1.0, 2.0, "odom")
    assert heard.th == pytest.approx(0.5)
    assert heard.time(0.0) == datetime(2023, 11, 14, 22, 13, 20, 500_000, tzinfo=UTC)
    assert Heard(0, 0, 0, "", 0.0).time(1_700_000_000.0).year == 2023


def test_a_stamped_pose_is_read_too() -> None:
    sent = pose_message(3.0, 4.0, 0.0, "map", 1.0)
    heard = read_heard(message(**sent))
    assert heard is not None
    assert (heard.x, heard.y, heard.at) == (3.0, 4.0, 1.0)


@pytest.mark.parametrize("number", [nan, inf, -inf])
def test_numbers_that_are_none_are_no_pose(number: float) -> None:
    assert read_heard(odometry(number, 0.0, 0.0)) is None
    assert read_heard(odometry(0.0, number, 0.0)) is None


def test_a_time_is_of_two_parts() -> None:
    assert stamp_seconds(message(sec=2, nanosec=250_000_000)) == 2.25


@pytest.mark.parametrize(
    ("age", "taken_at"), [(0.0, 50.0), (0.5, 49.5), (10.0, 40.0), (10.5, 50.0), (-0.5, 50.0), (1e9, 50.0)]
)
def test_a_picture_was_taken_at_its_stamp_where_the_clocks_agree(age: float, taken_at: float) -> None:
    wall = 1_700_000_000.0
    stamp = message(sec=int(wall - age), nanosec=round((wall - age) % 1 * 1e9))
    assert image_time(stamp, 50.0, wall) == pytest.approx(taken_at, abs=1e-3)
