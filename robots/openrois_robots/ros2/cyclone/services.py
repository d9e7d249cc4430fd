"""Clients of services over DDS, as `rmw_cyclonedds_cpp` has them: a topic of requests and a topic of replies.

A request begins with the id of its client and a number, and the reply repeats both; a client drops the replies to
others. The id in the user data of both ends lets a server wait until its replies have a way to the client.
"""

import asyncio
import secrets
from collections.abc import Mapping
from typing import Any, Final

from openrois_robots.ros2.cyclone.participant import Participant, dds_qos
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.backend import ANSWER_TIMEOUT, NoAnswer
from openrois_robots.ros2.graph.matching import Qos, topic_problem
from openrois_robots.ros2.graph.names import reply_topic, request_topic
from openrois_robots.ros2.interfaces.definitions import ServiceDefinition

__all__ = ["SERVICE_QOS", "DdsServiceClient"]

SERVICE_QOS: Final = Qos("reliable", "volatile", 64)
"""Of requests and replies. The replies to other clients come to each of them, so there is room for many."""
_MOST: Final = 64
"""Requests of one client that may wait for their replies."""


class DdsServiceClient:
    """A client of a service.

    Args:
        participant: its participant.
        types: makes its types.
        name: of the service.
        service: its definition.
        called: what it is in sentences: `the service /say`.
    """

    def __init__(
        self, participant: Participant, types: TypeMaker, name: str, service: ServiceDefinition, called: str
    ) -> None:
        self.name = name
        self._called = called
        self._participant = participant
        self._types = types
        self._service = service
        self._guid = secrets.randbits(63) | 1
        self._number = 0
        self._waiting: dict[int, asyncio.Future[Any]] = {}
        request, reply = types.with_header(service.request.name), types.with_header(service.response.name)
        user_data = f"clientid={'.'.join(f'{byte:x}' for byte in self._guid.to_bytes(16))};".encode()
        qos = dds_qos(SERVICE_QOS, user_data)
        self._reader = participant.reader(reply_topic(name), reply, qos, self._on_reply, self._on_change)
        self._writer = participant.writer(request_topic(name), request, qos, self._on_change)

    @property
    def is_matched(self) -> bool:
        """Whether there is a server."""
        return self._writer.matches > 0 and self._reader.matches > 0

    @property
    def problem(self) -> str:
        """Why there is none."""
        if self.is_matched:
            return ""
        peers = self._participant.peers("subscribe", request_topic(self.name))
        if not peers:
            return f"no node serves {self._called}"
        why = topic_problem("publish", self.name, self._service.request.name, SERVICE_QOS, peers)
        return why.replace(f"{self.name} is subscribed to", f"{self._called} is served", 1)

    async def call(self, request: Mapping[str, Any], timeout: float = ANSWER_TIMEOUT) -> Any:
        """Return the response to a request.

        Raises:
            NoAnswer: there is no server, it has not answered within `timeout` seconds, or it is gone.
        """
        try:
            async with asyncio.timeout(timeout):
                return await self.send_request(request)
        except TimeoutError:
            raise NoAnswer(f"{self._called} has not answered within {timeout:g} s") from None

    def send_request(self, request: Mapping[str, Any]) -> "asyncio.Future[Any]":
        """Send a request; return a future with the response, which may be cancelled. `NoAnswer` as `call` raises it."""
        if not self.is_matched:
            raise NoAnswer(self.problem)
        if len(self._waiting) >= _MOST:
            raise NoAnswer(f"{self._called} has {_MOST} requests to answer; wait for its replies")
        self._number += 1
        number = self._number
        self._writer.write(self._types.framed(self._service.request.name, self._guid, number, request))
        waiting: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._waiting[number] = waiting
        waiting.add_done_callback(lambda _: self._waiting.pop(number, None))
        return waiting

    def close(self) -> None:
        """Remove it from the graph; what waits fails."""
        self._fail("the node leaves the graph of ROS")
        self._participant.close_ends(self._reader, self._writer)

    def _on_reply(self, reply: Any) -> None:
        waiting = self._waiting.get(reply.cdds_seq) if reply.cdds_guid == self._guid else None
        if waiting is not None and not waiting.done():
            waiting.set_result(reply)

    def _on_change(self, is_lost: bool) -> None:
        if is_lost:
            self._fail(f"the node that serves {self._called} is gone")

    def _fail(self, why: str) -> None:
        for waiting in tuple(self._waiting.values()):
            if not waiting.done():
                waiting.set_exception(NoAnswer(why))
                waiting.exception()  # one that is not awaited any more needs no complaint
