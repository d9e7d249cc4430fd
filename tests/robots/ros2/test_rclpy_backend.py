"""rclpy keeps the contract of a backend, where a ROS with Cyclone DDS is installed; and what is said where none is."""

import importlib.util
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from unittest.mock import patch

import pytest
from openrois_robots.ros2.rclpy_backend import RclpyBackend, is_rclpy_installed

from tests.robots.ros2.backend_suite import BackendSuite
from tests.support.ros_graph import URI

LACKING = "rclpy is not installed, and comes with ROS 2 alone: a node of a real ROS was not tried"


@asynccontextmanager
async def joined(domain: int) -> AsyncIterator[RclpyBackend]:
    with patch.dict(os.environ, {"CYCLONEDDS_URI": URI, "RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}):
        async with RclpyBackend(domain) as backend:
            yield backend


@pytest.mark.skipif(not is_rclpy_installed(), reason=LACKING)
class TestRclpy(BackendSuite):
    __test__ = True

    def backend(self, domain: int) -> Any:
        return joined(domain)


@pytest.mark.skipif(is_rclpy_installed(), reason="rclpy is installed")
async def test_without_ros_it_is_said_what_to_do() -> None:
    assert importlib.util.find_spec("rclpy") is None
    with pytest.raises(OSError, match=r"rclpy cannot be imported: .*; source the setup file of ROS first"):
        async with RclpyBackend(0):
            pass
