"""Servers of services and actions over DDS, for nodes that stand in for a robot's: the simulator, and tests."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
from contextlib import aclosing, suppress
from dataclasses import dataclass
from typing import Any, Final, Protocol

from openrois.aio.tasks import TaskScope
from openrois.errors import ComponentFailed
from openrois_robots.ros2.cyclone.actions import FEEDBACK_QOS
from openrois_robots.ros2.cyclone.participant import Participant, dds_qos
from openrois_robots.ros2.cyclone.services import SERVICE_QOS
from openrois_robots.ros2.cyclone.types import TypeMaker
from openrois_robots.ros2.graph.matching import Qos
from openrois_robots.ros2.graph.names import dds_topic, reply_topic, request_topic
from openrois_robots.ros2.interfaces.definitions import ServiceDefinition
from openrois_robots.ros2.interfaces.derived import action_messages

__all__ = ["Aborted", "DdsActionServer", "DdsServiceServer", "Execution"]

_KEPT: Final = 100
"""Goals whose results are kept."""
_ROUND: Final = 0.01
_ROUNDS: Final = 10
"""Seconds between two looks for a client's reader, and how many there are, as `rmw_cyclonedds_cpp` has them."""
_STATUS_QOS: Final = Qos("reliable", "transient_local", 1)
_EXECUTING, _CANCELING, _SUCCEEDED, _CANCELED, _ABORTED = 2, 3, 4, 5, 6


class DdsServiceServer:
    """A server of a service.

    Args:
        participant: its participant.
        types: makes its types.
        name: of the service.
        service: its definition.
        answer: returns the response to a request.
        tasks: own the answering.
    """

    def __init__(
        self,
        participant: Participant,
        types: TypeMaker,
        name: str,
        service: ServiceDefinition,
        answer: Callable[[Any], Awaitable[Mapping[str, Any]]],
        tasks: TaskScope,
    ) -> None:
        self._types = types
        self._response = service.response.name
        self._answer = answer
        self._tasks = tasks
        request, reply = types.with_header(service.request.name), types.with_header(service.response.name)
        qos = dds_qos(SERVICE_QOS)
        self._writer = participant.writer(reply_topic(name), reply, qos, lambda _is_lost: None)
        self._reader = participant.reader(request_topic(name), request, qos, self._on_request, lambda _is_lost: None)

    def _on_request(self, request: Any) -> None:
        self._tasks.start(self._reply(request))

    async def _reply(self, request: Any) -> None:
        reply = self._types.framed(self._response, request.cdds_guid, request.cdds_seq, await self._answer(request))
        user_data = self._reader.user_data_of(request)
        for _ in range(_ROUNDS):
            # A reply that is written before the client's reader is matched does not reach it.
            if user_data is None or self._writer.has_reader_of(user_data):
                break
            await asyncio.sleep(_ROUND)
        self._writer.write(reply)


class Aborted(Exception):
    """Ends the execution of a goal: it is aborted, with a result.

    Args:
        result: its fields.
    """

    def __init__(self, result: Mapping[str, Any]) -> None:
        super().__init__("the goal is aborted")
        self.result = result


class Execution(Protocol):
    """Executes goals."""

    def accepts(self, goal: Any) -> bool:
        """Return whether a goal is accepted."""
        ...

    def execute(self, goal: Any) -> AsyncGenerator[Mapping[str, Any], None]:
        """Execute a goal and yield feedback until it has succeeded; closed where the goal is cancelled.

        Raises:
            Aborted: it cannot be done.
        """
        ...


@dataclass(slots=True)
class _Executed:
    """A goal, what has become of it, and its task."""

    status: int
    result: Mapping[str, Any]
    ended: asyncio.Event
    task: "asyncio.Task[None] | None" = None


class DdsActionServer:
    """A server of an action, which executes its goals side by side.

    Args:
        participant: its participant.
        types: makes its types.
        name: of the action.
        type_name: of the action.
        execution: executes goals.
        tasks: own the executions.
    """

    def __init__(
        self,
        participant: Participant,
        types: TypeMaker,
        name: str,
        type_name: str,
        execution: Execution,
        tasks: TaskScope,
    ) -> None:
        self._types = types
        self._execution = execution
        self._tasks = tasks
        self._goals: dict[bytes, _Executed] = {}
        messages = action_messages(types.interfaces.action(type_name))
        self._feedback_name = messages.feedback.name

        def serve(part: str, service: ServiceDefinition, answer: Callable[[Any], Any]) -> None:
            DdsServiceServer(participant, types, f"{name}/_action/{part}", service, answer, tasks)

        serve("send_goal", messages.send_goal, self._on_goal)
        serve("get_result", messages.get_result, self._on_get_result)
        serve("cancel_goal", types.interfaces.service("action_msgs/srv/CancelGoal"), self._on_cancel)
        self._feedback = participant.writer(
            dds_topic(f"{name}/_action/feedback"),
            types.message(self._feedback_name),
            dds_qos(FEEDBACK_QOS),
            lambda _is_lost: None,
        )
        self._status = participant.writer(
            dds_topic(f"{name}/_action/status"),
            types.message("action_msgs/msg/GoalStatusArray"),
            dds_qos(_STATUS_QOS),
            lambda _is_lost: None,
        )

    async def _on_goal(self, request: Any) -> Mapping[str, Any]:
        goal_id = bytes(request.goal_id.uuid)
        if goal_id in self._goals or not self._execution.accepts(request.goal):
            return {"accepted": False}
        goal = self._goals[goal_id] = _Executed(_EXECUTING, {}, asyncio.Event())
        while len(self._goals) > _KEPT:
            ended = next((key for key, each in self._goals.items() if each.ended.is_set()), None)
            if ended is None:
                break
            del self._goals[ended]
        goal.task = self._tasks.start(self._run(goal_id, goal, request.goal))
        return {"accepted": True}

    async def _run(self, goal_id: bytes, goal: _Executed, asked: Any) -> None:
        try:
            self._publish_status()
            async with aclosing(self._execution.execute(asked)) as steps:
                async for feedback in steps:
                    message = {"goal_id": {"uuid": goal_id}, "feedback": feedback}
                    self._feedback.write(self._types.value(self._feedback_name, message))
            goal.status = _SUCCEEDED
        except Aborted as end:
            goal.status, goal.result = _ABORTED, end.result
        except asyncio.CancelledError:
            goal.status = _CANCELED if goal.status == _CANCELING else _ABORTED
        finally:
            goal.ended.set()
            self._publish_status()

    async def _on_get_result(self, request: Any) -> Mapping[str, Any]:
        goal = self._goals.get(bytes(request.goal_id.uuid))
        if goal is None:
            return {"status": 0}
        await goal.ended.wait()
        return {"status": goal.status, "result": goal.result}

    async def _on_cancel(self, request: Any) -> Mapping[str, Any]:
        goal_id = bytes(request.goal_info.goal_id.uuid)
        goal = self._goals.get(goal_id)
        if goal is None or goal.task is None:
            return {"return_code": 2}
        if goal.ended.is_set():
            return {"return_code": 3}
        goal.status = _CANCELING
        goal.task.cancel()
        return {"return_code": 0, "goals_canceling": [{"goal_id": {"uuid": goal_id}}]}

    def _publish_status(self) -> None:
        statuses = [
            {"goal_info": {"goal_id": {"uuid": key}}, "status": each.status} for key, each in self._goals.items()
        ]
        # While the node leaves the graph there is nothing to publish on.
        with suppress(ComponentFailed):
            self._status.write(self._types.value("action_msgs/msg/GoalStatusArray", {"status_list": statuses}))
