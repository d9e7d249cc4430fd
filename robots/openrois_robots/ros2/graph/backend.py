"""The contract of what connects an adapter to a graph of ROS 2: topics, services and actions of other nodes.

Outgoing messages are mappings of fields, and what they leave out has its default. Incoming messages are objects with
the fields as attributes; their sequences of bytes are bytes, or an array of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, Protocol, Self, TypeAlias

from openrois.errors import ComponentFailed
from openrois_robots.ros2.graph.matching import Qos

__all__ = [
    "ANSWER_TIMEOUT",
    "ActionClient",
    "Goal",
    "GoalLost",
    "GoalRejected",
    "GoalResult",
    "Matched",
    "NoAnswer",
    "Outcome",
    "Publisher",
    "RosBackend",
    "ServiceClient",
    "Subscription",
]

ANSWER_TIMEOUT: Final = 1.0
"""Seconds within which a server has to answer to a request, unless the caller says another time."""

Outcome: TypeAlias = Literal["succeeded", "canceled", "aborted", "unknown"]
"""The end of a goal, as `action_msgs/msg/GoalStatus` names them."""


class NoAnswer(ComponentFailed):
    """A service or action without a server, or one that has not answered in time; the text names it."""


class GoalRejected(ComponentFailed):
    """A goal that its server has not accepted."""


class GoalLost(ComponentFailed):
    """A goal whose server is gone before its end."""


class Matched(Protocol):
    """An end of ours that needs one of another node."""

    @property
    def name(self) -> str:
        """The name of the topic, service or action, from the root on."""
        ...

    @property
    def is_matched(self) -> bool:
        """Whether there is another end that it matches."""
        ...

    @property
    def problem(self) -> str:
        """Why there is none, and what to change; empty while there is one."""
        ...

    def close(self) -> None:
        """Remove it from the graph; it may be called more than once."""
        ...


class Publisher(Matched, Protocol):
    """A publisher of a topic."""

    def publish(self, message: Mapping[str, Any]) -> None:
        """Publish a message; it does not wait.

        Raises:
            ComponentFailed: the middleware refused it.
            ValueError: it has a field that its type does not have, or a value that does not fit.
        """
        ...


class Subscription(Matched, Protocol):
    """A subscription to a topic; its messages arrive in the event loop, and `problem` says why they cannot be read."""


class ServiceClient(Matched, Protocol):
    """A client of a service."""

    async def call(self, request: Mapping[str, Any], timeout: float = ANSWER_TIMEOUT) -> Any:
        """Return the response to a request.

        Raises:
            NoAnswer: there is no server, it has not answered within `timeout` seconds, or it is gone.
        """
        ...


@dataclass(frozen=True, slots=True)
class GoalResult:
    """How a goal has ended, and its result, whose fields mean something where it has succeeded."""

    outcome: Outcome
    result: Any


class Goal(Protocol):
    """A goal that a server has accepted."""

    async def result(self) -> GoalResult:
        """Wait for the end of the goal.

        Raises:
            GoalLost: its server is gone.
        """
        ...

    async def cancel(self, timeout: float = ANSWER_TIMEOUT) -> None:
        """Ask the server to cancel the goal; return when it does, or has no such goal any more.

        Raises:
            NoAnswer: it has not answered within `timeout` seconds, or it refused.
        """
        ...


class ActionClient(Matched, Protocol):
    """A client of an action."""

    async def send_goal(
        self,
        goal: Mapping[str, Any],
        on_feedback: Callable[[Any], None] = lambda _feedback: None,
        timeout: float = ANSWER_TIMEOUT,
    ) -> Goal:
        """Send a goal; return when it is accepted.

        A goal whose acceptance is not waited for to its end, because that takes too long or the task is cancelled, is
        cancelled as soon as it is accepted.

        Raises:
            GoalRejected: the server does not accept it.
            NoAnswer: there is no server, or it has not answered within `timeout` seconds.
        """
        ...


class RosBackend(Protocol):
    """A node in a graph of ROS 2; `async with` it. Names are from the root on, as `resolve_name` returns them."""

    async def __aenter__(self) -> Self:
        """Enter the graph."""
        ...

    async def __aexit__(self, *error: object) -> None:
        """Leave the graph, with all ends."""
        ...

    def publisher(self, topic: str, type_name: str, qos: Qos) -> Publisher:
        """Return a publisher.

        Raises:
            DefinitionError: the type is not known.
        """
        ...

    def subscribe(self, topic: str, type_name: str, qos: Qos, on_message: Callable[[Any], None]) -> Subscription:
        """Call `on_message` in the event loop with each message; of those that wait the newest `depth` are kept.

        Raises:
            DefinitionError: the type is not known.
        """
        ...

    def service(self, name: str, type_name: str) -> ServiceClient:
        """Return a client of a service.

        Raises:
            DefinitionError: the type is not known.
        """
        ...

    def action(self, name: str, type_name: str) -> ActionClient:
        """Return a client of an action.

        Raises:
            DefinitionError: the type is not known.
        """
        ...
