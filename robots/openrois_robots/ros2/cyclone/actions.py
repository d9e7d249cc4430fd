"""Clients of actions over DDS: the services and the feedback that an action consists of."""

import asyncio
import secrets
from collections.abc import Callable, Mapping
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois_robots.ros2.cyclone.participant import Participant, dds_qos
from openrois_robots.ros2.cyclone.services import DdsServiceClient
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.backend import (
    ANSWER_TIMEOUT,
    Goal,
    GoalLost,
    GoalRejected,
    GoalResult,
    NoAnswer,
    Outcome,
)
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.graph.names import dds_topic
from openrois_robots.ros2.interfaces.derived import action_messages

__all__ = ["FEEDBACK_QOS", "OUTCOMES", "DdsActionClient"]

FEEDBACK_QOS: Final = Qos("reliable", "volatile", 10)
OUTCOMES: Final[Mapping[int, Outcome]] = {4: "succeeded", 5: "canceled", 6: "aborted"}
"""The statuses of `action_msgs/msg/GoalStatus` that end a goal."""
_CANCEL: Final = "action_msgs/srv/CancelGoal"
_GONE: Final = frozenset({2, 3})
"""What `CancelGoal` returns for a goal that its server does not know, or that has ended."""
_LATE: Final = 10.0
"""Seconds for which the acceptance of a goal that is not wanted any more is waited for."""


class DdsActionClient:
    """A client of an action.

    Args:
        participant: its participant.
        types: makes its types.
        name: of the action.
        type_name: of the action.
        tasks: of the backend.
    """

    def __init__(self, participant: Participant, types: TypeMaker, name: str, type_name: str, tasks: TaskScope) -> None:
        self.name = name
        self._called = f"the action {name}"
        self._participant = participant
        self._tasks = tasks
        self._listening: dict[bytes, Callable[[Any], None]] = {}
        messages = action_messages(types.interfaces.action(type_name))

        def client(part: str, service: Any) -> DdsServiceClient:
            return DdsServiceClient(participant, types, f"{name}/_action/{part}", service, self._called)

        self._send = client("send_goal", messages.send_goal)
        self._get = client("get_result", messages.get_result)
        self._cancel = client("cancel_goal", types.interfaces.service(_CANCEL))
        self._feedback = participant.reader(
            dds_topic(f"{name}/_action/feedback"),
            types.message(messages.feedback.name),
            dds_qos(FEEDBACK_QOS),
            self._on_feedback,
            lambda _is_lost: None,
        )

    @property
    def is_matched(self) -> bool:
        """Whether there is a server, with all its parts."""
        services = (self._send, self._get, self._cancel)
        return all(each.is_matched for each in services) and self._feedback.matches > 0

    @property
    def problem(self) -> str:
        """Why there is none."""
        if self.is_matched:
            return ""
        problems = (each.problem for each in (self._send, self._get, self._cancel))
        return next(filter(None, problems), f"{self._called} gives no feedback yet")

    async def send_goal(
        self,
        goal: Mapping[str, Any],
        on_feedback: Callable[[Any], None] = lambda _feedback: None,
        timeout: float = ANSWER_TIMEOUT,
    ) -> Goal:
        """Send a goal; return when it is accepted, as `ActionClient` says."""
        if not self.is_matched:
            raise NoAnswer(self.problem)
        goal_id = secrets.token_bytes(16)
        self._listening[goal_id] = on_feedback
        accepting = self._send.send_request({"goal_id": {"uuid": goal_id}, "goal": goal})
        try:
            async with asyncio.timeout(timeout):
                response = await asyncio.shield(accepting)
            if not response.accepted:
                raise GoalRejected(f"{self._called} has rejected the goal")
            result = self._get.send_request({"goal_id": {"uuid": goal_id}})
        except TimeoutError:
            self._abandon(goal_id, accepting)
            raise NoAnswer(f"{self._called} has not answered to a goal within {timeout:g} s") from None
        except BaseException:
            self._abandon(goal_id, accepting)
            raise
        result.add_done_callback(lambda _: self._listening.pop(goal_id, None))
        return _DdsGoal(self, goal_id, result, self._called)

    async def cancel(self, goal_id: bytes, timeout: float) -> None:
        """Cancel a goal; called by the goal."""
        stamp = {"sec": 0, "nanosec": 0}
        response = await self._cancel.call({"goal_info": {"goal_id": {"uuid": goal_id}, "stamp": stamp}}, timeout)
        if response.return_code not in {0, *_GONE}:
            raise NoAnswer(f"{self._called} refuses to cancel the goal (code {response.return_code})")

    def close(self) -> None:
        """Remove it from the graph."""
        for client in (self._send, self._get, self._cancel):
            client.close()
        self._participant.close_ends(self._feedback)

    def _on_feedback(self, message: Any) -> None:
        listener = self._listening.get(bytes(message.goal_id.uuid))
        if listener is not None:
            listener(message.feedback)

    def _abandon(self, goal_id: bytes, accepting: "asyncio.Future[Any]") -> None:
        self._listening.pop(goal_id, None)
        if not (accepting.done() and (accepting.cancelled() or accepting.exception() is not None)):
            self._tasks.start(self._cancel_accepted(goal_id, accepting))

    async def _cancel_accepted(self, goal_id: bytes, accepting: "asyncio.Future[Any]") -> None:
        """Cancel a goal that is not wanted any more, once it is accepted."""
        try:
            async with asyncio.timeout(_LATE):
                response = await accepting
            if response.accepted:
                await self.cancel(goal_id, ANSWER_TIMEOUT)
        except (NoAnswer, TimeoutError):
            return


class _DdsGoal:
    """A goal that was accepted; a `Goal`."""

    def __init__(self, client: DdsActionClient, goal_id: bytes, result: "asyncio.Future[Any]", called: str) -> None:
        self._client = client
        self._goal_id = goal_id
        self._result = result
        self._called = called

    async def result(self) -> GoalResult:
        """Wait for the end of the goal."""
        try:
            response = await asyncio.shield(self._result)
        except NoAnswer as error:
            raise GoalLost(f"the goal is lost: {error}") from None
        return GoalResult(OUTCOMES.get(response.status, "unknown"), response.result)

    async def cancel(self, timeout: float = ANSWER_TIMEOUT) -> None:
        """Cancel the goal."""
        await self._client.cancel(self._goal_id, timeout)
