"""A component in this process: typed messages as methods, a parameter store, and the life cycle of RoIS_Common."""

import asyncio
import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cached_property, partial
from typing import Any, ClassVar, Final, Literal, Self, final

from openrois.catalog.component_type import ComponentType
from openrois.catalog.payload import Payload
from openrois.component.authoring.parameters import ParameterStore, check_arguments
from openrois.component.authoring.reading import AuthoredType, Message, own_type, read_class
from openrois.component.start_slot import StartSlot
from openrois.errors import Aborted, BadParameter, ComponentFailed, RoISError, TimedOut, Unsupported, require_usable
from openrois.types.codes import ComponentFunction, ComponentStatus, ErrorType
from openrois.types.messages import Argument, Result
from openrois.types.profiles import HRIComponentProfile
from openrois.types.references import flaw_of_name

__all__ = ["DEAD_MAN", "Component", "Emit", "Report"]

_log = logging.getLogger(__name__)

Emit = Callable[[str, tuple[Result, ...]], None]
"""Announces an event of the component: its type and its results."""
Report = Callable[[ErrorType, str], None]
"""Reports a fault of the component: its kind, and a sentence for a person."""

DEAD_MAN: Final = 0.5
"""Seconds within which `stop` of a component is called when no application is in control: its `dead_man` says so."""

DISCONNECT_TIMEOUT: Final = 5.0
"""Seconds that a component has to let go of what it is connected to."""

_MILLISECOND: Final = 0.001


class Component:
    """Base of every component in this process. A subclass writes its messages as methods:

        class Lamp(Component, authority="Example", function="actuation"):
            brightness: int = parameter(80, description="per cent")

            @command
            async def start(self) -> None: ...

            @query
            async def power(self) -> float: ...

            @event
            def switched(self, on: bool) -> None: ...

    Its type and profile are read from it when the class is made; what cannot be on the wire is a TypeError then.

    Of `start` one runs at a time: `stop` ends it with ABORT once the component's own `stop` has run, and so does the
    next `start`. A `stop` ends what was started before it came, and nothing else. Other commands run side by side. A
    failure is a `RoISError`, which keeps its kind; whatever else a message raises is the component's ERROR, and is
    reported.

    Class arguments:
        code: the code of the type; the class's name unless given. A subclass is of the same type unless it says so.
        authority: defines the type.
        function: actuation, sensing or function: an actuation has to be bound before it is operated.
        part: of the body that it is or moves, such as `legs` or `voice`: of an engine's components that name the same
            one application has all, or none. Empty for a component by itself.
        implements: a type of the catalog; messages that have its names have to fit it.
        omit: events and parameters of that type that the class does without.

    Args:
        name: of the instance, unique behind one engine id; the type's unless given.

    Raises:
        BadParameter: `name` cannot be part of a reference.
    """  # noqa: D415 - the sentence ends in the example

    name: str
    emit: Emit
    parameters: ParameterStore
    component_type: ClassVar[ComponentType]
    dead_man: ClassVar[float | None] = None
    __authored: ClassVar[AuthoredType]
    __kind: ClassVar[ComponentType | None] = None
    __omitted: ClassVar[frozenset[str]] = frozenset()
    __running: int
    __starts: StartSlot[tuple[Result, ...]]
    __loop: asyncio.AbstractEventLoop | None
    __report: Report
    __standing: ComponentStatus
    __unconnected: str

    def __init_subclass__(
        cls,
        *,
        code: str = "",
        authority: str = "",
        function: ComponentFunction | Literal["actuation", "sensing", "function"] | None = None,
        part: str | None = None,
        implements: ComponentType | None = None,
        omit: Collection[str] = (),
        **more: Any,
    ) -> None:
        super().__init_subclass__(**more)
        cls.__kind = own_type(cls, implements or cls.__kind, code, authority, function, part)
        cls.__omitted = cls.__omitted | set(omit)
        cls.__authored = read_class(cls, cls.__kind, _RESERVED, cls.__omitted)
        cls.component_type = cls.__authored.component_type

    def __new__(cls, *_arguments: Any, **_named: Any) -> Self:
        """Make an instance that works whether or not its own `__init__` calls this class's."""
        if cls is Component:
            raise TypeError("Component is a base class: extend it, as in class Lamp(Component)")
        self = super().__new__(cls)
        self.name = cls.component_type.name
        self.emit = _nobody_listens
        self.report = _nobody_watches
        self.parameters = ParameterStore(cls.__authored.parameters)
        self.__running = 0
        self.__starts = StartSlot()
        self.__loop = None
        self.__unconnected = ""
        self.__standing = ComponentStatus.READY if cls.connect is Component.connect else ComponentStatus.UNINITIALIZED
        return self

    def __init__(self, name: str | None = None) -> None:
        if name is None:
            return
        if flaw := flaw_of_name(name):
            raise BadParameter(f"{name!r} cannot name a component: {flaw}")
        self.name = name

    @cached_property
    def profile(self) -> HRIComponentProfile:
        """The component type of the instance."""
        return self.component_type.profile(self.name)

    # The following may be overridden by an author.

    async def connect(self) -> None:
        """Reach what the component depends on: a device, a driver. Until it returns the component is UNINITIALIZED.

        If it raises, the component is in ERROR, and it is called again after a while.
        """

    async def disconnect(self) -> None:
        """Let go of what `connect` reached; nothing runs any more. It has a few seconds."""

    def condition(self) -> ComponentStatus:
        """Return READY, or what keeps the component from working now."""
        return ComponentStatus.READY

    def problem(self) -> str:
        """Return why `condition` is not READY, for refusals: a sentence without a full stop; empty: no more is known.

        It is asked for only then. Must not block or raise.
        """
        return ""

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Return what to store for parameters that an application sets; each fits its type.

        Raises:
            BadParameter: one of them cannot be used; none is stored.
        """
        return changes

    def subscribers_changed(self, event_type: str, number: int) -> None:
        """Note how many subscribe to an event now: without subscribers it needs no work. Must not block or raise."""

    def holder_lost(self) -> None:
        """Take back what holds for one application: the one that held the component does not any more.

        It has released or lent it, or is gone; also where another application holds it by now. Must not block or raise.
        """

    # The following is for a registry and an adapter.

    @property
    def status(self) -> ComponentStatus:
        """The result of the query `component_status`."""
        condition = self.__condition() if self.__standing is ComponentStatus.READY else self.__standing
        return ComponentStatus.BUSY if self.__running and condition is ComponentStatus.READY else condition

    @property
    def report(self) -> Report:
        """Reports a fault to applications that have bound the component, from any thread: its kind and a sentence."""
        return partial(self.__in_loop, self.__report)

    @report.setter
    def report(self, report: Report) -> None:
        self.__report = report

    @final
    async def ask(self, query_type: str) -> tuple[Result, ...]:
        """Answer a query.

        Raises:
            Unsupported: the profile has no such query.
            ComponentFailed: the component is not READY or BUSY; `component_status` and `get_parameter` always answer.
        """
        if query_type == "get_parameter":
            return self.parameters.told()
        if not self.profile.has_query(query_type):
            raise Unsupported(f"{self.name} has no query {query_type!r}")
        message = self.__authored.queries.get(query_type)
        if message is None:
            return (Result(name="status", data_type_ref="Component_Status", value=self.status.value),)
        self.require_usable()
        return await self.__call(message, None)

    @final
    async def run(self, command_type: str, arguments: tuple[Argument, ...]) -> tuple[Result, ...]:
        """Run a command to its end.

        Raises:
            Unsupported: the profile has no such command.
            BadParameter: an argument is unknown, repeated, missing, or not of its type.
            ComponentFailed: the component is not READY or BUSY; `stop` is then tried all the same, if it is connected.
            Aborted: `stop` or another `start` ended it.
            TimedOut: it took longer than its profile allows.
            RoISError: whatever the command raises.
        """
        if command_type == "set_parameter":
            return self.__set_parameters(check_arguments(self.profile.parameter_profiles, arguments))
        message = self.__authored.commands.get(command_type)
        if message is None:
            raise Unsupported(f"{self.name} has no command {command_type!r}")
        is_usable = self.status in (ComponentStatus.READY, ComponentStatus.BUSY)
        if command_type != "stop" or self.__standing is not ComponentStatus.READY:
            self.require_usable()
        given = self.__read(message, arguments)
        self.__running += 1
        try:
            async with asyncio.timeout(None if message.timeout is None else message.timeout * _MILLISECOND):
                results = await self.__run_checked(message, given)
                if not is_usable:
                    # Whatever is wrong with what moves, it has been told to stop; now it is said.
                    self.require_usable()
                return results
        except TimeoutError:
            sentence = f"{self.name}: {command_type} took longer than {message.timeout} ms"
            self.report(ErrorType.COMPONENT_NOT_RESPONDING, sentence)
            raise TimedOut(sentence) from None
        finally:
            self.__running -= 1

    @final
    def require_usable(self, name: str | None = None) -> None:
        """Raise `ComponentFailed` where the component is not READY or BUSY, and say why.

        Args:
            name: of the component in the sentence; its own unless given.
        """
        status = self.status
        if status not in (ComponentStatus.READY, ComponentStatus.BUSY):
            problem = self.__unconnected if self.__standing is not ComponentStatus.READY else self.problem()
            require_usable(name or self.name, status, problem)

    def __rois_announce__(self, method: str, values: tuple[object, ...], named: Mapping[str, object]) -> None:
        """Announce the event behind a method, from any thread; one that the class omits is dropped.

        Raises:
            TypeError: the arguments are not the method's.
            ValueError: one is not of its type.
        """
        message = self.__authored.events.get(method)
        if message is None:
            return
        payload = message.arguments.bind(values, named)
        self.__in_loop(self.emit, message.name, () if payload is None else payload.named(Result))

    @final
    async def bring_up(self) -> bool:
        """Run `connect` and tell whether the component can be used now; a failure is reported."""
        self.__loop = asyncio.get_running_loop()
        try:
            with _containing_bugs(self, "connect", expected=OSError):
                await self.connect()
        except RoISError as error:
            _log.warning("%s is not connected: %s", self.name, error)
            self.__standing, self.__unconnected = ComponentStatus.ERROR, str(error)
            return False
        self.__standing = ComponentStatus.READY
        return True

    @final
    async def take_down(self) -> None:
        """End what runs and run `disconnect`, which has `DISCONNECT_TIMEOUT` seconds; a failure is logged."""
        await self.__starts.end_running()
        was_up, self.__standing = self.__standing is ComponentStatus.READY, ComponentStatus.UNINITIALIZED
        self.__unconnected = ""
        if was_up:
            try:
                async with asyncio.timeout(DISCONNECT_TIMEOUT):
                    await self.disconnect()
            except Exception as error:
                _log.warning("%s did not disconnect: %s", self.name, str(error) or "it took too long")

    # How it is done; authors may call their own attributes by the same names.

    def __in_loop(self, tell: Callable[..., None], *what: object) -> None:
        if self.__loop is None or self.__loop is _running_loop():
            tell(*what)
        else:
            with suppress(RuntimeError):
                # The loop is closed: there are no subscribers any more.
                self.__loop.call_soon_threadsafe(tell, *what)

    def __condition(self) -> ComponentStatus:
        try:
            with _containing_bugs(self, "condition"):
                return ComponentStatus(self.condition())
        except RoISError:
            return ComponentStatus.ERROR

    def __read(self, message: Message, arguments: tuple[Argument, ...]) -> Payload | None:
        profile = self.profile.command(message.name)
        texts = check_arguments(() if profile is None else profile.arguments, arguments)
        try:
            return None if message.arguments.payload is None else message.arguments.payload.from_texts(texts)
        except ValueError as error:
            raise BadParameter(str(error)) from None

    async def __run_checked(self, message: Message, given: Payload | None) -> tuple[Result, ...]:
        if message.name == "start":
            return await self.__starts.run(self.name, lambda: self.__call(message, given))
        before = self.__starts.came
        results = await self.__call(message, given)
        if message.name == "stop":
            await self.__starts.stop(before)
        return results

    async def __call(self, message: Message, given: Payload | None) -> tuple[Result, ...]:
        method = getattr(self, message.attribute)
        # An argument that was not given has its default in the payload already, or in the signature.
        arguments = {} if given is None else {name: getattr(given, name) for name in given.model_fields_set}
        with _containing_bugs(self, message.name):
            payload = message.results.read(await method(**arguments))
            return () if payload is None else payload.named(Result)

    def __set_parameters(self, texts: Mapping[str, str]) -> tuple[Result, ...]:
        with _containing_bugs(self, "set_parameter"):
            try:
                self.parameters.set_texts(texts, self.accept_parameters)
            except ValueError as error:
                raise BadParameter(str(error)) from None
        return ()


_RESERVED: Final = frozenset(name for name in vars(Component) if not name.startswith("_")) | {
    "component_type",
    "emit",
    "name",
    "parameters",
    "report",
}
"""Names that no message or parameter can have as an attribute."""


@contextmanager
def _containing_bugs(component: Component, message: str, expected: type[Exception] | tuple[()] = ()) -> Iterator[None]:
    """Turn an exception of the author's code into the component's failure, which is logged and reported."""
    try:
        yield
    except RoISError:
        raise
    except asyncio.CancelledError as error:
        task = asyncio.current_task()
        if task is None or task.cancelling():
            raise
        # The caller was not cancelled, and needs an answer.
        raise Aborted(f"{component.name}: {message} failed: a task that it awaited was cancelled") from error
    except Exception as error:
        if not isinstance(error, expected):  # Only the log of this process can tell where it failed.
            _log.exception("%s: %s failed", component.name, message)
        sentence = f"{component.name}: {message} failed: {error}"
        component.report(ErrorType.COMPONENT_INTERNAL_ERROR, sentence)
        raise ComponentFailed(sentence) from error


def _running_loop() -> asyncio.AbstractEventLoop | None:
    try:
        return asyncio.get_running_loop()
    except RuntimeError:
        return None


def _nobody_listens(_event_type: str, _results: tuple[Result, ...]) -> None:
    """Stand in until the component is in a registry: an event without subscribers is dropped."""


def _nobody_watches(_error_type: ErrorType, _description: str) -> None:
    """Stand in until the component is in a registry: a fault has no receiver yet."""
