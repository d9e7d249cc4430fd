"""SystemInformation of a robot: what it does not know it does not say."""

from datetime import UTC, datetime

import pytest
from openrois_robots.adapter.battery import BatteryLimit, ReportedBattery
from openrois_robots.components.system_information import Pose, SystemInformation

from openrois.adapter import ComponentFailed, ComponentStatus

AT = datetime(2026, 11, 24, 12, 0, 0, tzinfo=UTC)


class Robot:
    """What the robot has told."""

    def __init__(self) -> None:
        self.status, self.problem = ComponentStatus.READY, ""
        self.pose: Pose | None = None
        self.battery = ReportedBattery(BatteryLimit(15.0))
        self.information = SystemInformation(
            "robot", lambda: self.status, lambda: self.problem, lambda: self.pose, self.battery, lambda: AT.timestamp()
        )


async def test_a_pose_has_its_frame_and_its_time() -> None:
    robot = Robot()
    robot.pose = Pose(1.0, -2.5, 0.25, "map", AT)
    told = await robot.information.robot_position()
    assert (told.position_data, told.robot_ref, told.timestamp) == (("1.000,-2.500,0.2500",), ("robot",), AT)
    pose = await robot.information.pose()
    assert (pose.x, pose.y, pose.th, pose.frame, pose.timestamp) == (1.0, -2.5, 0.25, "map", AT)


@pytest.mark.parametrize(
    ("problem", "sentence"),
    [("", "the robot has not told where it is"), ("the robot is asleep", "the robot is asleep")],
)
async def test_a_pose_that_is_not_known_is_no_pose(problem: str, sentence: str) -> None:
    robot = Robot()
    robot.problem = problem
    for asked in (robot.information.robot_position, robot.information.pose):
        with pytest.raises(ComponentFailed, match=sentence):
            await asked()


async def test_the_battery_is_told_once_it_is_known() -> None:
    robot = Robot()
    with pytest.raises(ComponentFailed, match="the robot has not told the charge of its battery"):
        await robot.information.battery()
    robot.battery.percent, robot.battery.is_charging = 12, True
    told = await robot.information.battery()
    assert (told.percent, told.is_charging, told.is_low) == (12, True, True)


@pytest.mark.parametrize(
    ("status", "percent", "told"),
    [
        (ComponentStatus.READY, None, ComponentStatus.READY),
        (ComponentStatus.READY, 14, ComponentStatus.WARNING),
        (ComponentStatus.ERROR, 14, ComponentStatus.ERROR),
        (ComponentStatus.UNINITIALIZED, None, ComponentStatus.UNINITIALIZED),
    ],
)
async def test_its_status_warns_of_a_low_battery(
    status: ComponentStatus, percent: int | None, told: ComponentStatus
) -> None:
    robot = Robot()
    robot.status, robot.battery.percent = status, percent
    answer = await robot.information.engine_status()
    assert (answer.status, answer.operable_time) == (told, AT)


async def test_its_health_is_a_sentence() -> None:
    robot = Robot()
    assert await robot.information.health() == ""
    robot.problem = "the robot at 192.0.2.7 has not answered for 1 s"
    assert await robot.information.health() == robot.problem
