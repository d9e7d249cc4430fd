"""Cyclone DDS keeps the contract of a backend; and what is its own."""

import asyncio
import gc
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from openrois_robots.ros2.cyclone.backend import CycloneBackend
from openrois_robots.ros2.graph.backend import RosBackend
from openrois_robots.ros2.graph.matching import BEST_EFFORT, Qos
from openrois_robots.ros2.interfaces.definitions import DefinitionError
from openrois_robots.ros2.interfaces.store import Interfaces

from openrois.errors import ComponentFailed
from tests.robots.ros2.backend_suite import GO, STRING, BackendSuite
from tests.support.ros_graph import INTERFACES, URI, free_domain, until

pytestmark = pytest.mark.extra(name="ros2")


@asynccontextmanager
async def joined(domain: int) -> AsyncIterator[CycloneBackend]:
    with patch.dict(os.environ, {"CYCLONEDDS_URI": URI}):
        async with CycloneBackend(domain, Interfaces(folder=INTERFACES)) as backend:
            yield backend


class TestCyclone(BackendSuite):
    __test__ = True

    def backend(self, domain: int) -> Any:
        return joined(domain)

    async def test_a_server_with_another_definition_of_its_type_is_said(self) -> None:
        async with self.graph() as (backend, _):
            old = backend.action("/old", GO)
            await until(lambda: "another definition" in old.problem, "nothing was said of the definition")
            assert "the action /old is served as nav2_msgs/action/NavigateToPose_" in old.problem
            assert "name its distribution" in old.problem


async def test_settings_that_dds_does_not_take_are_named_with_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CYCLONEDDS_URI", "file:///etc/einstellungen-für-dds.xml")
    with pytest.raises(OSError, match="CYCLONEDDS_URI has the character 'ü': name a file whose path is ASCII alone"):
        async with CycloneBackend(free_domain(), Interfaces(folder=INTERFACES)):
            pass


async def test_of_messages_that_wait_the_newest_are_kept() -> None:
    domain = free_domain()
    async with joined(domain) as sender, joined(domain) as receiver:
        heard: list[str] = []
        subscription = receiver.subscribe("/many", STRING, BEST_EFFORT, lambda message: heard.append(message.data))
        publisher = sender.publisher("/many", STRING, Qos())
        await until(lambda: publisher.is_matched and subscription.is_matched, "they did not match")
        # The event loop is busy meanwhile.
        for number in range(500):
            publisher.publish({"data": str(number)})
        await until(lambda: heard[-1:] == ["499"], "the newest did not come")
        assert len(heard) < 10


async def test_a_message_that_cannot_be_read_is_dropped_alone_and_its_topic_says_so() -> None:
    domain = free_domain()
    async with joined(domain) as sender, joined(domain) as receiver:
        heard: list[str] = []
        subscription = receiver.subscribe("/odd", STRING, Qos(), lambda message: heard.append(message.data))
        publisher = sender.publisher("/odd", STRING, Qos())
        await until(lambda: publisher.is_matched and subscription.is_matched, "they did not match")
        codec: Any = type(sender._types.value(STRING, {}))

        class Latin(codec):  # type: ignore[misc]
            def serialize(self, *_arguments: object, **_more: object) -> bytes:
                return bytes.fromhex("00010000 03000000 e9e800")

        odd = Latin("")
        publisher.publish({"data": "before"})
        publisher._writer.write(odd)
        publisher.publish({"data": "after"})
        await until(lambda: len(heard) == 2, "what can be read did not come")
        assert heard == ["before", "after"]
        assert subscription.problem == ""
        publisher._writer.write(odd)
        await until(lambda: subscription.problem, "nothing was said of it")
        assert subscription.problem.startswith(
            "what comes on /odd cannot be read as std_msgs/msg/String: UnicodeDecodeError: "
        )
        assert subscription.is_matched


async def test_nothing_is_left_of_ends_that_come_and_go() -> None:
    domain = free_domain()
    async with joined(domain) as robot, joined(domain) as other:
        publisher = other.publisher("/camera", STRING, Qos())
        tasks = len(asyncio.all_tasks())
        for _ in range(50):
            subscription = robot.subscribe("/camera", STRING, BEST_EFFORT, lambda _: None)
            action = robot.action("/go", GO)
            subscription.close()
            action.close()
        assert robot._participant._ends == []
        assert len(asyncio.all_tasks()) == tasks
        await until(lambda: not publisher.is_matched, "the publisher still has readers")
        assert other._participant.peers("subscribe", "rt/camera") == []


def entries(name: str) -> int:
    """Return how many threads (`task`) or files (`fd`) this process has."""
    return len(list(Path("/proc/self", name).iterdir()))


@pytest.mark.long
async def test_nothing_is_left_of_nodes_that_come_and_go() -> None:
    domain = free_domain()

    async def come_and_go() -> tuple[int, int, int]:
        """Return what the process has after a node: threads, files, and tasks."""
        async with joined(domain) as node:
            node.publisher("/one", STRING, Qos())
            node.action("/go", GO)
        gc.collect()
        return entries("task"), entries("fd"), len(asyncio.all_tasks())

    first = [await come_and_go() for _ in range(3)][-1]
    last = [await come_and_go() for _ in range(12)][-1]
    assert last <= first


async def test_a_domain_that_cannot_be_joined_is_said() -> None:
    with pytest.raises(OSError, match="DDS cannot join domain 400"):
        async with CycloneBackend(400, Interfaces()):
            pass


async def test_one_topic_with_two_types_is_refused() -> None:
    async with joined(free_domain()) as backend:
        backend.publisher("/one", STRING, Qos())
        with pytest.raises(ComponentFailed, match="rt/one is used with two types, std_msgs/msg/String and"):
            backend.publisher("/one", "geometry_msgs/msg/Twist", Qos())


async def test_types_that_are_not_known_are_said() -> None:
    async with joined(free_domain()) as backend:
        with pytest.raises(DefinitionError, match="kachaka_interfaces/msg/Nothing is not known"):
            backend.publisher("/one", "kachaka_interfaces/msg/Nothing", Qos())


async def test_a_value_that_does_not_fit_is_refused() -> None:
    async with joined(free_domain()) as backend:
        publisher = backend.publisher("/twist", "geometry_msgs/msg/Twist", Qos())
        with pytest.raises(ValueError, match="does not fit"):
            publisher.publish({"linear": {"x": "fast"}})


async def test_what_waits_ends_with_the_node() -> None:
    async with joined(free_domain()) as backend:
        kept: RosBackend = backend
        publisher = kept.publisher("/one", STRING, Qos())
    with pytest.raises(ComponentFailed, match="has left the graph"):
        publisher.publish({"data": "late"})
    await asyncio.sleep(0)
