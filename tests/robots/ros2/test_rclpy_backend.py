"""rclpy keeps the contract of a backend, where a ROS with Cyclone DDS is installed; and what is said where none is."""

import asyncio
import importlib.util
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import pytest
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.rclpy_backend import RclpyBackend, is_rclpy_installed

from openrois.errors import ComponentFailed
from tests.robots.ros2.backend_suite import BackendSuite
from tests.support.ros_graph import URI
from tests.support.streaming import settle

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


class Executor:
    """Spins until something of the robot cannot be read, some times; then it is shut down."""

    def __init__(self, *failures: Exception) -> None:
        self.failures = list(failures)
        self.turns = 0

    def spin(self) -> None:
        self.turns += 1
        if self.failures:
            raise self.failures.pop(0)


def test_what_cannot_be_read_ends_no_executor(caplog: pytest.LogCaptureFixture) -> None:
    backend = RclpyBackend(0)
    backend._context = SimpleNamespace(ok=lambda: True)
    executor = backend._executor = Executor(UnicodeDecodeError("utf-8", b"\xe9", 0, 1, "no text"), ValueError("no"))
    backend._spin()
    assert executor.turns == 3
    assert [record.getMessage().partition(": ")[0] for record in caplog.records] == [
        "rclpy could not hand on what a node has sent"
    ] * 2


def test_an_executor_whose_node_leaves_ends(caplog: pytest.LogCaptureFixture) -> None:
    backend = RclpyBackend(0)
    backend._context = SimpleNamespace(ok=lambda: False)
    executor = backend._executor = Executor(RuntimeError("the context is shut down"))
    backend._spin()
    assert executor.turns == 1
    assert caplog.records == []


class Node:
    """Makes entities that tests drive."""

    def __init__(self) -> None:
        self.receive: Any = None

    def create_subscription(self, _kind: object, _name: str, receive: Any, _qos: object) -> object:
        self.receive = receive
        return object()

    def create_publisher(self, _kind: object, _name: str, _qos: object) -> Any:
        def publish(_message: object) -> None:
            raise RuntimeError("publisher's context is invalid")

        return SimpleNamespace(publish=publish)


def with_node() -> tuple[RclpyBackend, Node]:
    backend, node = RclpyBackend(0), Node()
    backend.node, backend._loop = node, asyncio.get_running_loop()
    made: Any = backend
    made.type_of, made.qos_of = lambda _kind, _name: SimpleNamespace, lambda qos: qos
    return backend, node


async def test_a_message_that_is_not_understood_keeps_none_of_the_others() -> None:
    backend, node = with_node()
    complaints: list[object] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: complaints.append(context["exception"]))
    heard: list[int] = []

    def understand(message: int) -> None:
        if message == 1:
            raise TypeError("one")
        heard.append(message)

    backend.subscribe("/odom", "std_msgs/msg/Int8", Qos(), understand)
    for number in (0, 1, 2):
        node.receive(number)
    await settle()
    node.receive(3)
    await settle()
    assert heard == [0, 2, 3]
    assert len(complaints) == 1


async def test_of_messages_that_wait_the_newest_are_kept() -> None:
    backend, node = with_node()
    heard: list[int] = []
    subscription = backend.subscribe("/odom", "std_msgs/msg/Int8", Qos(depth=2), heard.append)
    for number in range(10):
        await asyncio.to_thread(node.receive, number) if number == 9 else node.receive(number)
    await settle()
    assert heard[-2:] == [8, 9]
    assert len(heard) <= 3
    subscription._entity = None
    node.receive(10)
    await settle()
    assert heard[-1] == 9


async def test_what_the_middleware_refuses_is_said() -> None:
    backend, _ = with_node()
    with pytest.raises(ComponentFailed, match="ROS refused a message: publisher's context is invalid"):
        backend.publisher("/cmd_vel", "geometry_msgs/msg/Twist", Qos()).publish({})


@pytest.mark.skipif(is_rclpy_installed(), reason="rclpy is installed")
async def test_without_ros_it_is_said_what_to_do() -> None:
    assert importlib.util.find_spec("rclpy") is None
    with pytest.raises(OSError, match=r"rclpy cannot be imported: .*; source the setup file of ROS first"):
        async with RclpyBackend(0):
            pass
