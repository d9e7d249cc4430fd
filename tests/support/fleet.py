"""Robots with all seventeen basic components, made of the catalog, with simple but real behaviour."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final, cast

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.component_type import ComponentType
from openrois.catalog.payload import Payload
from openrois.catalog.streaming import ConnectStreamResults, NotifyStreamStatus, StreamArguments, StreamStatusResults
from openrois.component.authoring.parameters import check_arguments
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, Unsupported, require_usable
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentStatus, ErrorType, StreamStatus
from openrois.types.messages import Argument, Parameter, Result

__all__ = ["NOON", "Part", "Robot", "everything", "example", "fleet"]

NOON: Final = datetime(2026, 6, 1, 12, tzinfo=UTC)
"""When everything happens."""

_BY_NAME: Final[Mapping[str, Any]] = {
    "position_data": ["1.0,2.0,0.5"],
    "robot_ref": ["urn:x-rois:def:robot:Test::body"],
    "person_ref": ["urn:x-rois:def:person:Test::alice"],
    "face_ref": ["urn:x-rois:def:face:Test::1"],
    "sound_ref": ["urn:x-rois:def:sound:Test::1"],
    "gesture_ref": ["urn:x-rois:def:gesture:Test::wave"],
    "recognized_text": ["good morning", "could warning"],
    "languages": ["en", "ja"],
    "characters": ["default", "deep"],
    "available_reactions": ["nod", "bow"],
    "target": "lobby",
    "stream_id": "stream-1",
    "status": "READY",
}
_BY_CODE: Final[Mapping[str, Any]] = {"int": 1, "bool": True, "double": 0.5, "string": "text", "datetime": NOON}


def example(payload: type[Payload], **values: Any) -> Payload:
    """Return a payload with `values`, and something that fits for every other one."""
    chosen: dict[str, Any] = {}
    for name, data in payload.data().items():
        code = data.code.lower()
        if code == "stream_status":
            chosen[name] = "STREAMING_RUNNING"
        else:
            plain = _BY_CODE.get(code.removesuffix("[]"), "text")
            chosen[name] = _BY_NAME.get(name, [plain] if code.endswith("[]") else plain)
    return payload.model_validate(chosen | values)


class Part:
    """A component made of its type, with the run-time face that a registry needs.

    `start` of one that senses announces each of its events once; of Navigation it announces every target position; of
    Follow it goes on until `stop` ends it with ABORT; of all others it is done at once. Streams are connected,
    suspended and ended as they should be, without any media.

    Attributes:
        kind: its type.
        is_in: its status while no command runs; a test may set it.
        done: the commands that were run, in order.
        following: set while Follow goes on.
    """

    def __init__(self, kind: ComponentType, name: str = "") -> None:
        self.kind = kind
        self.profile = kind.profile(name)
        self.emit: Callable[[str, tuple[Result, ...]], None] = lambda _event_type, _results: None
        self.report: Callable[[ErrorType, str], None] = lambda _error_type, _description: None
        self.parameters = {each.name: each.default_value for each in self.profile.parameter_profiles}
        self.is_in = ComponentStatus.READY
        self.done: list[str] = []
        self.following = asyncio.Event()
        self.streams: dict[str, StreamStatus] = {}
        self._numbers = itertools.count(1)
        self._running = 0
        self._starts: set[asyncio.Task[Any]] = set()

    async def connect(self) -> None:
        """Connect nothing: the component can be used at once."""

    async def disconnect(self) -> None:
        """End what still runs."""
        self._abort()

    @property
    def status(self) -> ComponentStatus:
        """What `component_status` answers."""
        return ComponentStatus.BUSY if self._running and self.is_in is ComponentStatus.READY else self.is_in

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Ignore subscribers: events are announced with and without them."""

    def tell(self, event_type: str, **values: Any) -> Payload:
        """Announce an event with `values` and examples for the rest; return its results."""
        kind = next(each for each in self.kind.all_events() if each.name == event_type)
        payload = example(kind.results, **values)
        self.emit(event_type, payload.named(Result))
        return payload

    async def ask(self, query_type: str) -> tuple[Result, ...]:
        """Answer a query."""
        if query_type == "get_parameter":
            return tuple(
                Parameter(name=each.name, data_type_ref=each.data_type_ref.code, value=value)
                for each in self.profile.parameter_profiles
                if (value := self.parameters[each.name])
            )
        if not self.profile.has_query(query_type):
            raise Unsupported(f"{self.profile.name} has no query {query_type!r}")
        if query_type == "component_status":
            return (Result(name="status", data_type_ref="Component_Status", value=self.status.value),)
        self.require_usable()
        if query_type == "get_stream_status":
            newest = next(reversed(self.streams.values()), StreamStatus.STREAMING_NOT_CONNECTED)
            return StreamStatusResults(status=newest).named(Result)
        kind = next(each for each in self.kind.all_queries() if each.name == query_type)
        return example(kind.results).named(Result)

    async def run(self, command_type: str, arguments: tuple[Argument, ...]) -> tuple[Result, ...]:
        """Run a command to its end."""
        if command_type == "set_parameter":
            self.parameters.update(check_arguments(self.profile.parameter_profiles, arguments))
            return ()
        command = self.profile.command(command_type)
        if command is None:
            raise Unsupported(f"{self.profile.name} has no command {command_type!r}")
        texts = check_arguments(command.arguments, arguments)
        self.require_usable()
        self._running += 1
        try:
            results = await self._run(command_type, texts)
        finally:
            self._running -= 1
        self.done.append(command_type)
        return () if results is None else results.named(Result)

    async def _run(self, command_type: str, texts: dict[str, str]) -> Payload | None:
        if command_type == "start":
            await self._start()
        elif command_type == "stop":
            self._abort()
        elif command_type == "connect_stream":
            stream_id = f"{self.profile.name}-{next(self._numbers)}"
            self._move(stream_id, StreamStatus.STREAMING_RUNNING)
            return ConnectStreamResults(stream_id=stream_id)
        elif command_type.endswith("_stream"):
            self._act(command_type, StreamArguments.from_texts(texts).stream_id)
        return None

    async def _start(self) -> None:
        self._abort()
        if self.kind.code == "Follow":
            await self._follow()
        if self.kind.code == "Navigation":
            self._arrive()
        elif self.kind.code not in ("AudioStreaming", "VideoStreaming"):
            for event in self.kind.all_events():
                self.tell(event.name)

    async def _follow(self) -> None:
        going_on = asyncio.ensure_future(asyncio.Event().wait())
        self._starts.add(going_on)
        self.following.set()
        try:
            await asyncio.wait({going_on})
        finally:
            going_on.cancel()
            self._starts.discard(going_on)
            if not self._starts:
                self.following.clear()
        raise Aborted(f"{self.profile.name} was stopped")

    def _arrive(self) -> None:
        assert self.kind.parameters is not None
        texts = {name: value for name, value in self.parameters.items() if value}
        targets = getattr(self.kind.parameters.from_texts(texts), "target_positions", None) or ()
        for number, target in enumerate(targets, 1):
            self.tell("reached_target", target=target, is_final_target=number == len(targets))

    def _abort(self) -> None:
        for start in self._starts:
            start.cancel()

    def _act(self, command_type: str, stream_id: str) -> None:
        if stream_id not in self.streams:
            raise BadParameter(f"there is no stream {stream_id!r}")
        if command_type == "disconnect_stream":
            self._move(stream_id, StreamStatus.STREAMING_NOT_CONNECTED)
            del self.streams[stream_id]
        elif command_type == "suspend_stream":
            self._move(stream_id, StreamStatus.STREAMING_SUSPENDED)
        else:
            self._move(stream_id, StreamStatus.STREAMING_RESUMED)
            self._move(stream_id, StreamStatus.STREAMING_RUNNING)

    def _move(self, stream_id: str, status: StreamStatus) -> None:
        self.streams[stream_id] = status
        told = NotifyStreamStatus(timestamp=NOON, status=status, stream_id=stream_id)
        self.emit("notify_stream_status", told.named(Result))

    def require_usable(self, name: str = "") -> None:
        require_usable(name or self.profile.name, self.status)


@dataclass(frozen=True)
class Robot:
    """An engine's components, and each of them by the code of its type, such as `Navigation`."""

    registry: LocalRegistry
    parts: Mapping[str, Part]

    @property
    def engine_id(self) -> str:
        """The id that leads its refs."""
        return self.registry.engine_id

    def ref(self, code: str) -> str:
        """Return the component_ref of the component of a type."""
        return f"{self.engine_id}/{self.parts[code].profile.name}"

    async def engine(self) -> Engine:
        """Return an engine of these components."""
        engine = Engine(self.engine_id)
        await engine.attach(self.registry)
        return engine


def everything(engine_id: str = "robot") -> Robot:
    """Return a robot with all seventeen basic components, named as in the standard: `robot/navigation`."""
    parts = {kind.code: Part(kind) for kind in BASIC_COMPONENTS}
    # A registry asks for nothing but the run-time face of a component.
    return Robot(LocalRegistry(engine_id, cast(Any, parts.values())), parts)


@asynccontextmanager
async def fleet(gateway_url: str, *robots: Robot) -> AsyncIterator[None]:
    """Connect robots, each an adapter of its own, to the gateway at `ws://host:port/adapter` while the block runs.

    Who needs to know when they are there waits for the gateway to have changed.
    """
    async with AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        dialling = [
            asyncio.ensure_future(serve_parent(EngineHost(await robot.engine(), tasks), gateway_url))
            for robot in robots
        ]
        try:
            yield
        finally:
            for each in dialling:
                each.cancel()
            await asyncio.wait(dialling)
