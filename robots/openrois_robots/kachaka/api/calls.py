"""Calls of one robot by the generated stub: each has a deadline, and fails in a sentence."""

from types import TracebackType
from typing import Any, Final, Self

import grpc
from kachaka_api.generated import kachaka_api_pb2 as pb2
from kachaka_api.generated.kachaka_api_pb2_grpc import KachakaApiStub

from openrois.adapter import ComponentFailed, Unsupported
from openrois_robots.kachaka.api.address import Address, unreachable

__all__ = ["DEADLINE", "KachakaApi", "RobotSilent", "RobotUnreachable", "get_request"]

DEADLINE: Final = 1.0
"""Seconds that a call may take. The robot answers within milliseconds."""

_LARGEST: Final = 64 << 20
"""Bytes of a message: maps are larger than the 4 MiB that gRPC takes without this."""

_OPTIONS: Final = (
    ("grpc.max_receive_message_length", _LARGEST),
    # Without a limit gRPC waits up to two minutes before it tries again, and 20 s for one attempt.
    ("grpc.initial_reconnect_backoff_ms", 200),
    ("grpc.min_reconnect_backoff_ms", 1000),
    ("grpc.max_reconnect_backoff_ms", 1000),
    # The robot is in the same network, whatever proxy the environment names.
    ("grpc.enable_http_proxy", 0),
    ("grpc.use_local_subchannel_pool", 1),
)
"""No keepalive: the robot's server takes its pings for an attack, and a hung robot was noticed by none."""


class RobotUnreachable(ComponentFailed):
    """There is no connection to the robot, or it broke."""


class RobotSilent(ComponentFailed):
    """The robot has not answered in time."""


class KachakaApi:
    """The API of one robot; `async with` it.

    Args:
        address: of the robot.
    """

    def __init__(self, address: Address) -> None:
        self.address = address
        self._channel: Any = None
        self._stub: Any = None

    async def __aenter__(self) -> Self:
        # Nothing is looked up or connected here: that happens with the first call, within its deadline.
        self._channel = grpc.aio.insecure_channel(self.address.target, options=_OPTIONS)
        self._stub = KachakaApiStub(self._channel)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._channel.close()

    async def call(self, method: str, request: Any = None, *, deadline: float = DEADLINE) -> Any:
        """Return the response to a request.

        Args:
            method: of the service: `GetRobotPose`.
            request: its message; a `GetRequest` without a cursor unless given.
            deadline: seconds that the robot has for it.

        Raises:
            RobotUnreachable: there is no connection to the robot.
            RobotSilent: it has not answered in time.
            Unsupported: the robot's software does not have the method.
            ComponentFailed: it failed otherwise.
        """
        try:
            return await getattr(self._stub, method)(get_request() if request is None else request, timeout=deadline)
        except grpc.aio.AioRpcError as error:
            raise _failure(method, error, deadline) from None


def get_request(cursor: int = 0) -> pb2.GetRequest:
    """Return the request of a state: with 0 it is answered at once, with another cursor when that is old."""
    return pb2.GetRequest(metadata=pb2.Metadata(cursor=cursor))


def _failure(method: str, error: grpc.aio.AioRpcError, deadline: float) -> ComponentFailed | Unsupported:
    code, details = error.code(), error.details() or ""
    if code is grpc.StatusCode.UNAVAILABLE:
        return RobotUnreachable(unreachable(details))
    if code is grpc.StatusCode.DEADLINE_EXCEEDED:
        return RobotSilent(f"{method} was not answered within {deadline:g} s")
    if code is grpc.StatusCode.UNIMPLEMENTED:
        return Unsupported(f"the robot has no {method}: its software may be too old, or what answers is no Kachaka")
    return ComponentFailed(f"{method} failed: {details or code.name}")
