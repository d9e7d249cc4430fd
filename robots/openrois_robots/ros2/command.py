"""`openrois robot ros2`: connect a robot that speaks ROS 2 until a signal stops it."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Final

from openrois_streaming.clock import SystemClock

from openrois.extras import needing_extra
from openrois_robots.adapter.hosting import RunningRobot
from openrois_robots.adapter.options import AdapterSettings
from openrois_robots.adapter.process import RobotCommand
from openrois_robots.ros2.adapter import hosted_robot, ros_robot
from openrois_robots.ros2.graph.backend import RosBackend
from openrois_robots.ros2.interfaces.store import Interfaces
from openrois_robots.ros2.mapping.settings import RobotMapping, Ros
from openrois_robots.ros2.options import TABLES, add_options, domain_of, read_settings
from openrois_robots.ros2.rclpy_backend import RclpyBackend, is_rclpy_installed

__all__ = ["COMMAND", "backend_of"]

_log = logging.getLogger(__name__)


def backend_of(ros: Ros) -> RosBackend:
    """Return the node that the settings ask for.

    Raises:
        MissingExtra: it is to be one of Cyclone DDS, which is not installed.
        ValueError: the domain of the environment is none.
    """
    domain = domain_of(ros)
    if ros.backend == "rclpy" or (ros.backend == "auto" and is_rclpy_installed()):
        _log.info("the graph of ROS: by rclpy, in domain %d", domain)
        return RclpyBackend(domain)
    with needing_extra("ros2"):
        from openrois_robots.ros2.cyclone.backend import CycloneBackend
    _log.info("the graph of ROS: by Cyclone DDS without ROS, in domain %d", domain)
    folder = Path(ros.interfaces) if ros.interfaces else None
    return CycloneBackend(domain, Interfaces(ros.distribution, folder))


@asynccontextmanager
async def _run(settings: AdapterSettings, mapping: RobotMapping) -> AsyncIterator[RunningRobot]:
    clock = SystemClock()
    called = f"the robot in ROS domain {domain_of(mapping.ros)}"
    async with (
        backend_of(mapping.ros) as backend,
        ros_robot(settings.engine_id, mapping, backend, clock, called) as robot,
        hosted_robot(settings.engine_id, robot, clock, settings.network, settings.components) as running,
    ):
        yield running


COMMAND: Final = RobotCommand(
    "ros2",
    "A robot that speaks ROS 2, behind a gateway: a mapping file binds its topics and actions to components.",
    "robot",
    TABLES,
    add_options,
    read_settings,
    _run,
)
"""The command of a robot that speaks ROS 2."""
