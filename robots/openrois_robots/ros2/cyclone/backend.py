"""A node over Cyclone DDS alone; a `RosBackend`. Services and actions are those of robots with rmw_cyclonedds_cpp."""

from collections.abc import Callable
from contextlib import AsyncExitStack
from typing import Any, Self

from openrois.aio.tasks import TaskScope
from openrois_robots.ros2.cyclone.actions import DdsActionClient
from openrois_robots.ros2.cyclone.participant import Participant
from openrois_robots.ros2.cyclone.services import DdsServiceClient
from openrois_robots.ros2.cyclone.topics import DdsPublisher, DdsSubscription
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.interfaces.store import Interfaces

__all__ = ["CycloneBackend"]


class CycloneBackend:
    """A node; `async with` it. CYCLONEDDS_URI configures DDS, as it does with ROS.

    Args:
        domain: number of the DDS domain: ROS_DOMAIN_ID of the robot.
        interfaces: definitions of all types.

    Raises:
        OSError: (on entering) DDS cannot join the domain.
    """

    def __init__(self, domain: int, interfaces: Interfaces) -> None:
        self._types = TypeMaker(interfaces)
        self._participant = Participant(domain)
        self._tasks = TaskScope()
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            await stack.enter_async_context(self._participant)
            await stack.enter_async_context(self._tasks)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(self, *_error: object) -> None:
        await self._stack.aclose()

    def publisher(self, topic: str, type_name: str, qos: Qos) -> DdsPublisher:
        """Return a publisher."""
        return DdsPublisher(self._participant, self._types, topic, type_name, qos)

    def subscribe(self, topic: str, type_name: str, qos: Qos, on_message: Callable[[Any], None]) -> DdsSubscription:
        """Return a subscription."""
        return DdsSubscription(self._participant, self._types, topic, type_name, qos, on_message)

    def service(self, name: str, type_name: str) -> DdsServiceClient:
        """Return a client of a service."""
        service = self._types.interfaces.service(type_name)
        return DdsServiceClient(self._participant, self._types, name, service, f"the service {name}")

    def action(self, name: str, type_name: str) -> DdsActionClient:
        """Return a client of an action."""
        return DdsActionClient(self._participant, self._types, name, type_name, self._tasks)
