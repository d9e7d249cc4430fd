"""A node of an installed ROS 2, by rclpy; a `RosBackend`. Whatever middleware the robot has, it speaks it.

rclpy comes with ROS alone, and is imported when the node is made. Its executor runs in a thread of its own: callbacks
bring what they have into the event loop, where at most as many messages wait as a subscription is deep.

Source: https://docs.ros.org/en/jazzy/p/rclpy/. Without an installed ROS it was not run.
"""

import asyncio
import importlib
import importlib.util
import logging
import threading
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import SimpleNamespace
from typing import Any, Final, Self

from openrois.aio.tasks import TaskScope
from openrois.errors import ComponentFailed
from openrois_robots.ros2.graph.backend import (
    ANSWER_TIMEOUT,
    Goal,
    GoalLost,
    GoalRejected,
    GoalResult,
    NoAnswer,
    Outcome,
)
from openrois_robots.ros2.graph.matching import Direction, Peer, Qos, is_match, topic_problem
from openrois_robots.ros2.interfaces.definitions import DefinitionError

__all__ = ["RclpyBackend", "is_rclpy_installed"]

_log = logging.getLogger(__name__)

NODE: Final = "openrois"
_JOIN: Final = 5.0
"""Seconds that the executor's thread has to end."""
_LOOK: Final = 0.5
"""Seconds between two looks for the server of a goal that runs."""
_LATE: Final = 10.0
"""Seconds for which the acceptance of a goal that is not wanted any more is waited for."""
_OUTCOMES: Final[Mapping[int, Outcome]] = {4: "succeeded", 5: "canceled", 6: "aborted"}
_GONE: Final = frozenset({2, 3})
"""What `CancelGoal` returns for a goal that its server does not know, or that has ended."""


def is_rclpy_installed() -> bool:
    """Return whether the environment of a ROS is set up in this process, so that rclpy can be imported."""
    return importlib.util.find_spec("rclpy") is not None


class RclpyBackend:
    """A node; `async with` it.

    Args:
        domain: ROS_DOMAIN_ID of the robot.
        name: of the node.

    Raises:
        OSError: (on entering) rclpy cannot be imported, or cannot make a node.
    """

    def __init__(self, domain: int, name: str = NODE) -> None:
        self._domain = domain
        self._name = name
        self._ros = SimpleNamespace()
        self._context: Any = None
        self._executor: Any = None
        self.node: Any = None
        self.tasks = TaskScope()
        self._thread: threading.Thread | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        try:
            for part in ("action", "context", "executors", "qos", "signals"):
                setattr(self._ros, part, importlib.import_module(f"rclpy.{part}"))
            self._ros.rclpy = importlib.import_module("rclpy")
            self._ros.types = importlib.import_module("rosidl_runtime_py.utilities")
        except ImportError as error:
            raise OSError(f"rclpy cannot be imported: {error}; source the setup file of ROS first") from None
        self._context = self._ros.context.Context()
        try:
            # The process has its own way to end.
            no_handlers = self._ros.signals.SignalHandlerOptions.NO
            self._ros.rclpy.init(
                args=[], context=self._context, domain_id=self._domain, signal_handler_options=no_handlers
            )
            self.node = self._ros.rclpy.create_node(self._name, context=self._context)
        except Exception as error:  # What the middleware raises is of its own kinds.
            raise OSError(f"rclpy cannot make a node in domain {self._domain}: {error}") from None
        self._executor = self._ros.executors.SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, name="rclpy executor", daemon=True)
        self._thread.start()
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.tasks.__aexit__(None, None, None)
        await asyncio.to_thread(self._shut_down)

    def publisher(self, topic: str, type_name: str, qos: Qos) -> "RclpyPublisher":
        """Return a publisher."""
        return RclpyPublisher(self, topic, type_name, qos)

    def subscribe(self, topic: str, type_name: str, qos: Qos, on_message: Callable[[Any], None]) -> "RclpySubscription":
        """Return a subscription."""
        return RclpySubscription(self, topic, type_name, qos, on_message)

    def service(self, name: str, type_name: str) -> "RclpyServiceClient":
        """Return a client of a service."""
        return RclpyServiceClient(self, name, type_name)

    def action(self, name: str, type_name: str) -> "RclpyActionClient":
        """Return a client of an action."""
        return RclpyActionClient(self, name, type_name)

    def type_of(self, kind: str, name: str) -> Any:
        """Return the class of a message, service or action.

        Raises:
            DefinitionError: no installed package has it.
        """
        try:
            return getattr(self._ros.types, f"get_{kind}")(name)
        except (ImportError, AttributeError, ValueError) as error:
            raise DefinitionError(f"{name} is not known to the installed ROS: {error}") from None

    def qos_of(self, qos: Qos) -> Any:
        """Return a quality of service as rclpy has it."""
        kinds = self._ros.qos
        return kinds.QoSProfile(
            history=kinds.HistoryPolicy.KEEP_LAST,
            depth=qos.depth,
            reliability=getattr(kinds.ReliabilityPolicy, qos.reliability.upper()),
            durability=getattr(kinds.DurabilityPolicy, qos.durability.upper()),
        )

    def peers(self, direction: Direction, topic: str) -> list[Peer]:
        """Return the ends of other nodes that an end of ours with this direction may match."""
        subscribes = direction == "subscribe"
        look = self.node.get_publishers_info_by_topic if subscribes else self.node.get_subscriptions_info_by_topic
        return [_peer(each) for each in look(topic) if each.node_name != self._name]

    def action_client(self, kind: Any, name: str) -> Any:
        """Return rclpy's client of an action."""
        return self._ros.action.ActionClient(self.node, kind, name)

    def call(self, function: Callable[..., None], *arguments: object) -> None:
        """Call a function in the event loop, from any thread."""
        assert self._loop is not None
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function, *arguments)

    def bridged(self, future: Any) -> "asyncio.Future[Any]":
        """Return a future of the event loop that ends as one of rclpy does."""
        assert self._loop is not None
        bridged: asyncio.Future[Any] = self._loop.create_future()

        def settle() -> None:
            if bridged.done():
                return
            if (error := future.exception()) is not None:
                bridged.set_exception(NoAnswer(str(error)))
                bridged.exception()  # one that is not awaited any more needs no complaint
            else:
                bridged.set_result(future.result())

        future.add_done_callback(lambda _: self.call(settle))
        return bridged

    def destroy(self, destroy: Callable[[Any], Any], entity: Any) -> None:
        """Destroy an entity in the executor's thread, where no callback of it runs."""
        if self._executor is not None:
            self._executor.create_task(lambda: destroy(entity))

    def _spin(self) -> None:
        executor = self._executor
        while True:
            try:
                executor.spin()
            except (
                Exception
            ) as error:  # What a message raises that rclpy cannot read; a context that is shut down raises.
                if self._executor is None or not self._context.ok():
                    return
                _log.warning("rclpy could not hand on what a node has sent: %s: %s", type(error).__name__, error)
            else:
                return

    def _shut_down(self) -> None:
        executor, self._executor = self._executor, None
        executor.shutdown(timeout_sec=_JOIN)
        if self._thread is not None:
            self._thread.join(_JOIN)
        self.node.destroy_node()
        self._ros.rclpy.shutdown(context=self._context)


class _OfTopic:
    """An end of ours of a topic."""

    def __init__(self, backend: RclpyBackend, direction: Direction, name: str, type_name: str, qos: Qos) -> None:
        self.name = name
        self._backend = backend
        self._direction = direction
        self._type_name = type_name
        self._qos = qos
        self._entity: Any = None

    @property
    def is_matched(self) -> bool:
        """Whether another node has an end that matches."""
        peers = self._backend.peers(self._direction, self.name)
        return any(is_match(self._direction, self._type_name, self._qos, peer) for peer in peers)

    @property
    def problem(self) -> str:
        """Why none has."""
        if self.is_matched:
            return ""
        peers = self._backend.peers(self._direction, self.name)
        return topic_problem(self._direction, self.name, self._type_name, self._qos, peers)


class RclpyPublisher(_OfTopic):
    """A publisher of a topic."""

    def __init__(self, backend: RclpyBackend, name: str, type_name: str, qos: Qos) -> None:
        super().__init__(backend, "publish", name, type_name, qos)
        self._kind = backend.type_of("message", type_name)
        self._entity = backend.node.create_publisher(self._kind, name, backend.qos_of(qos))

    def publish(self, message: Mapping[str, Any]) -> None:
        """Publish a message."""
        if self._entity is None:
            raise ComponentFailed("the node has left the graph of ROS")
        filled = _filled(self._kind(), message)
        try:
            self._entity.publish(filled)
        except Exception as error:  # What the middleware raises is of its own kinds.
            raise ComponentFailed(f"ROS refused a message: {error}") from None

    def close(self) -> None:
        """Remove it from the graph."""
        entity, self._entity = self._entity, None
        if entity is not None:
            self._backend.destroy(self._backend.node.destroy_publisher, entity)


class RclpySubscription(_OfTopic):
    """A subscription to a topic."""

    def __init__(
        self, backend: RclpyBackend, name: str, type_name: str, qos: Qos, on_message: Callable[[Any], None]
    ) -> None:
        super().__init__(backend, "subscribe", name, type_name, qos)
        self._on_message = on_message
        self._waiting: deque[Any] = deque(maxlen=qos.depth)
        kind = backend.type_of("message", type_name)
        self._entity = backend.node.create_subscription(kind, name, self._receive, backend.qos_of(qos))

    def close(self) -> None:
        """Remove it from the graph."""
        entity, self._entity = self._entity, None
        if entity is not None:
            self._backend.destroy(self._backend.node.destroy_subscription, entity)

    def _receive(self, message: Any) -> None:
        """Receive a message, in the executor's thread."""
        is_first = not self._waiting
        self._waiting.append(message)
        if is_first:
            self._backend.call(self._drain)

    def _drain(self) -> None:
        """Hand one message on, and come back for the next one, whatever becomes of this one."""
        if not self._waiting or self._entity is None:
            return
        message = self._waiting.popleft()
        try:
            self._on_message(message)
        finally:
            if self._waiting:
                self._backend.call(self._drain)


class RclpyServiceClient:
    """A client of a service."""

    def __init__(self, backend: RclpyBackend, name: str, type_name: str) -> None:
        self.name = name
        self._backend = backend
        self._type_name = type_name
        self._kind = backend.type_of("service", type_name)
        self._client = backend.node.create_client(self._kind, name)

    @property
    def is_matched(self) -> bool:
        """Whether there is a server."""
        return self._client is not None and bool(self._client.service_is_ready())

    @property
    def problem(self) -> str:
        """Why there is none."""
        if self.is_matched:
            return ""
        for name, types in self._backend.node.get_service_names_and_types():
            if name == self.name and self._type_name not in types:
                return f"the service {name} is served as {types[0]}, and the mapping file has {self._type_name}"
        return f"no node serves the service {self.name}"

    async def call(self, request: Mapping[str, Any], timeout: float = ANSWER_TIMEOUT) -> Any:
        """Return the response to a request."""
        if not self.is_matched:
            raise NoAnswer(self.problem)
        answering = self._backend.bridged(self._client.call_async(_filled(self._kind.Request(), request)))
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout):
                while not answering.done():
                    await asyncio.wait({answering}, timeout=_LOOK)
                    if not answering.done() and not self.is_matched:
                        raise NoAnswer(f"the node that serves the service {self.name} is gone")
                return await answering
        raise NoAnswer(f"the service {self.name} has not answered within {timeout:g} s")

    def close(self) -> None:
        """Remove it from the graph."""
        client, self._client = self._client, None
        if client is not None:
            self._backend.destroy(self._backend.node.destroy_client, client)


class RclpyActionClient:
    """A client of an action."""

    def __init__(self, backend: RclpyBackend, name: str, type_name: str) -> None:
        self.name = name
        self._backend = backend
        self._kind = backend.type_of("action", type_name)
        self._client = backend.action_client(self._kind, name)

    @property
    def is_matched(self) -> bool:
        """Whether there is a server."""
        return self._client is not None and bool(self._client.server_is_ready())

    @property
    def problem(self) -> str:
        """Why there is none."""
        return "" if self.is_matched else f"no node serves the action {self.name}"

    async def send_goal(
        self,
        goal: Mapping[str, Any],
        on_feedback: Callable[[Any], None] = lambda _feedback: None,
        timeout: float = ANSWER_TIMEOUT,
    ) -> Goal:
        """Send a goal; return when it is accepted, as `ActionClient` says."""
        if not self.is_matched:
            raise NoAnswer(self.problem)

        def receive(message: Any) -> None:
            self._backend.call(on_feedback, message.feedback)

        sent = self._client.send_goal_async(_filled(self._kind.Goal(), goal), feedback_callback=receive)
        accepting = self._backend.bridged(sent)
        try:
            async with asyncio.timeout(timeout):
                handle = await asyncio.shield(accepting)
        except TimeoutError:
            self._backend.tasks.start(self._cancel_accepted(accepting))
            raise NoAnswer(f"the action {self.name} has not answered to a goal within {timeout:g} s") from None
        except asyncio.CancelledError:
            self._backend.tasks.start(self._cancel_accepted(accepting))
            raise
        if not handle.accepted:
            raise GoalRejected(f"the action {self.name} has rejected the goal")
        return _RclpyGoal(self, self._backend, handle)

    def close(self) -> None:
        """Remove it from the graph."""
        client, self._client = self._client, None
        if client is not None:
            self._backend.destroy(lambda entity: entity.destroy(), client)

    async def _cancel_accepted(self, accepting: "asyncio.Future[Any]") -> None:
        """Cancel a goal that is not wanted any more, once it is accepted."""
        with suppress(NoAnswer, TimeoutError):
            async with asyncio.timeout(_LATE):
                handle = await accepting
            if handle.accepted:
                await _RclpyGoal(self, self._backend, handle).cancel()


class _RclpyGoal:
    """A goal that was accepted; a `Goal`."""

    def __init__(self, client: RclpyActionClient, backend: RclpyBackend, handle: Any) -> None:
        self._client = client
        self._backend = backend
        self._handle = handle
        self._ending = backend.bridged(handle.get_result_async())

    async def result(self) -> GoalResult:
        """Wait for the end of the goal. rclpy does not tell that a server is gone: it is looked for."""
        while not self._ending.done():
            await asyncio.wait({self._ending}, timeout=_LOOK)
            if not self._ending.done() and not self._client.is_matched:
                raise GoalLost(f"the goal is lost: the node that serves the action {self._client.name} is gone")
        response = self._ending.result()
        return GoalResult(_OUTCOMES.get(response.status, "unknown"), response.result)

    async def cancel(self, timeout: float = ANSWER_TIMEOUT) -> None:
        """Cancel the goal."""
        if not self._client.is_matched:
            raise NoAnswer(self._client.problem)
        try:
            async with asyncio.timeout(timeout):
                response = await self._backend.bridged(self._handle.cancel_goal_async())
        except TimeoutError:
            raise NoAnswer(f"the action {self._client.name} has not answered within {timeout:g} s") from None
        if response.return_code not in {0, *_GONE}:
            raise NoAnswer(f"the action {self._client.name} refuses to cancel the goal (code {response.return_code})")


def _peer(info: Any) -> Peer:
    qos = info.qos_profile
    is_reliable = "BEST_EFFORT" not in str(qos.reliability)
    is_kept = "TRANSIENT_LOCAL" in str(qos.durability)
    return Peer(
        info.topic_type,
        Qos("reliable" if is_reliable else "best_effort", "transient_local" if is_kept else "volatile"),
    )


def _filled(message: Any, values: Mapping[str, Any]) -> Any:
    """Fill in fields of a message of rclpy.

    Raises:
        ValueError: it has no such field, or a value does not fit.
    """
    for name, value in values.items():
        if not hasattr(message, name):
            raise ValueError(f"{type(message).__name__} has no field {name!r}")
        if isinstance(value, Mapping):
            _filled(getattr(message, name), value)
            continue
        try:
            # A field of floating point takes no integer.
            is_real = isinstance(getattr(message, name), float) and isinstance(value, int)
            setattr(message, name, float(value) if is_real else value)
        except (AssertionError, TypeError) as error:
            raise ValueError(f"a value does not fit its field {name}: {error}") from None
    return message
