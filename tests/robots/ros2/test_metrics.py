"""The figures of a robot that speaks ROS 2."""

import pytest
from openrois_robots.adapter.metrics import LINK
from openrois_robots.ros2.adapter import hosted_robot

from tests.support.ros_robot import staged

pytestmark = pytest.mark.extra(name="ros2")


async def test_they_say_whether_the_robot_is_linked() -> None:
    async with staged(is_linked=False) as stage, hosted_robot("robot", stage.robot, stage.clock) as running:

        async def linked() -> bool:
            (group,) = (each for each in (await running.collect_figures()).more if each.figures is LINK)
            ((_, is_linked),) = group.samples
            return bool(is_linked)

        assert not await linked()
        (requirement,) = running.requirements.values()
        assert not requirement()
        await stage.run(0.6)
        assert await linked()
        assert requirement()
