"""A component in this process: messages as methods, a parameter store, a status, and the commands of RoIS_Common."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Any, ClassVar, Final, TypeVar

from openrois.errors import Aborted, BadParameter, ComponentFailed, RoISError, TimedOut, Unsupported
from openrois.types.codes import ComponentStatus, ErrorType
from openrois.types.messages import Argument, Parameter, Result
from openrois.types.profiles import (
    HRIComponentProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
)
from openrois.types.values import check_value

__all__ = [
    "COMMON_QUERIES",
    "Component",
    "Emit",
    "Report",
    "check_arguments",
    "command",
    "parameter_profile",
    "query",
]

_log = logging.getLogger(__name__)

Arguments = dict[str, str]
CommandFunction = Callable[[Any, Arguments], Awaitable[tuple[Result, ...]]]
QueryFunction = Callable[[Any], Awaitable[tuple[Result, ...]]]
Emit = Callable[[str, tuple[Result, ...]], None]
"""Announces an event of the component: its type and its results."""
Report = Callable[[ErrorType, str], None]
"""Reports a fault of the component: its kind, and a sentence for a person."""

_MILLISECOND: Final = 0.001
_Function = TypeVar("_Function", bound=Callable[..., Awaitable[tuple[Result, ...]]])


def command(*names: str) -> Callable[[_Function], _Function]:
    """Mark a method as the one that runs the commands `names`: arguments by name in, results out at the end."""
    return _mark("_rois_commands", names)


def query(*names: str) -> Callable[[_Function], _Function]:
    """Mark a method as the one that answers the queries `names`."""
    return _mark("_rois_queries", names)


def _mark(attribute: str, names: tuple[str, ...]) -> Callable[[_Function], _Function]:
    def mark(function: _Function) -> _Function:
        setattr(function, attribute, names)
        return function

    return mark


def parameter_profile(name: str, type_code: str, default: str = "", description: str = "") -> ParameterProfile:
    """Return the profile of a parameter, argument or result whose type is a plain code such as `string` or `int`."""
    return ParameterProfile(
        name=name,
        data_type_ref=RoISIdentifier(code=type_code),
        default_value=default,
        description=description,
    )


COMMON_QUERIES: Final = (
    QueryMessageProfile(name="component_status", results=(parameter_profile("status", "Component_Status"),)),
)


class Component:
    """What every component in this process shares; a subclass marks its messages with `command` and `query`.

    A profile may only offer what a method does (`stop` and `component_status` need none), else `TypeError` is raised.

    Its status is READY, or BUSY while a command runs; a subclass that depends on something outside overrides
    `condition`. Of `start` one runs at a time: `stop` ends it with ABORT, and so does the next `start`. Other commands
    run side by side.
    """

    _commands: ClassVar[dict[str, str]]
    _queries: ClassVar[dict[str, str]]

    def __init__(self, profile: HRIComponentProfile) -> None:
        self.profile = profile
        self.emit: Emit = _nobody_listens
        self.report: Report = _nobody_watches
        self.parameters: dict[str, str] = {p.name: p.default_value for p in profile.parameter_profiles}
        self._require_methods()
        self._running = 0
        self._start: asyncio.Task[tuple[Result, ...]] | None = None

    def _require_methods(self) -> None:
        offered = {p.name for p in self.profile.command_profiles} - self._commands.keys() - {"stop"}
        offered |= {p.name for p in self.profile.query_profiles} - self._queries.keys() - {"component_status"}
        if offered:
            raise TypeError(f"{type(self).__name__} offers {', '.join(sorted(offered))} and has no method for it")

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        cls._commands = _collect(cls, "_rois_commands")
        cls._queries = _collect(cls, "_rois_queries")

    def condition(self) -> ComponentStatus:
        """Return READY, or what keeps the component from working."""
        return ComponentStatus.READY

    @property
    def status(self) -> ComponentStatus:
        """What `component_status` answers."""
        condition = self.condition()
        return ComponentStatus.BUSY if self._running and condition is ComponentStatus.READY else condition

    async def ask(self, query_type: str) -> tuple[Result, ...]:
        """Answer a query.

        Raises:
            Unsupported: the profile has no such query.
            ComponentFailed: the component is not READY or BUSY; `component_status` and `get_parameter` always answer.
        """
        if query_type == "get_parameter":
            return self._stored_parameters()
        if not self.profile.has_query(query_type):
            raise Unsupported(f"{self.profile.name} has no query {query_type!r}")
        if query_type == "component_status" and query_type not in self._queries:
            return (Result(name="status", data_type_ref="Component_Status", value=self.status.value),)
        self._require_usable()
        function: Callable[[], Awaitable[tuple[Result, ...]]] = getattr(self, self._queries[query_type])
        with self._containing_bugs(query_type):
            return await function()

    async def run(self, command_type: str, arguments: tuple[Argument, ...]) -> tuple[Result, ...]:
        """Run a command to its end.

        Raises:
            Unsupported: the profile has no such command.
            BadParameter: an argument is unknown, repeated, or not of its type.
            ComponentFailed: the component is not READY or BUSY.
            Aborted: `stop` or another `start` ended it.
            TimedOut: it took longer than its profile allows.
            RoISError: whatever the command raises.
        """
        if command_type == "set_parameter":
            return self._set_parameters(arguments)
        profile = self.profile.command(command_type)
        if profile is None:
            raise Unsupported(f"{self.profile.name} has no command {command_type!r}")
        values = check_arguments(profile.arguments, arguments)
        self._require_usable()
        self._running += 1
        try:
            async with asyncio.timeout(None if profile.timeout is None else profile.timeout * _MILLISECOND):
                return await self._run_checked(command_type, values)
        except TimeoutError:
            sentence = f"{self.profile.name}: {command_type} took longer than {profile.timeout} ms"
            self.report(ErrorType.COMPONENT_NOT_RESPONDING, sentence)
            raise TimedOut(sentence) from None
        finally:
            self._running -= 1

    async def _run_checked(self, command_type: str, values: Arguments) -> tuple[Result, ...]:
        if command_type == "start":
            return await self._run_start(values)
        results = await self._call(command_type, values)
        if command_type == "stop":
            await self._abort_start()
        return results

    async def _run_start(self, values: Arguments) -> tuple[Result, ...]:
        await self._abort_start()
        task = asyncio.ensure_future(self._call("start", values))
        self._start = task
        try:
            await asyncio.wait({task})
        except asyncio.CancelledError:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            raise
        finally:
            if self._start is task:
                self._start = None
        if task.cancelled():
            raise Aborted(f"{self.profile.name} was stopped")
        return task.result()

    async def _abort_start(self) -> None:
        # While this waits for one to end, another may have begun.
        while (task := self._start) is not None:
            task.cancel()
            await asyncio.wait({task})
            if self._start is task:
                self._start = None

    async def _call(self, command_type: str, values: Arguments) -> tuple[Result, ...]:
        name = self._commands.get(command_type)
        if name is None:
            # Only `stop` needs no method of its own: ending `start` is all there is to it.
            return ()
        function: Callable[[Arguments], Awaitable[tuple[Result, ...]]] = getattr(self, name)
        with self._containing_bugs(command_type):
            return await function(values)

    @contextmanager
    def _containing_bugs(self, message: str) -> Iterator[None]:
        try:
            yield
        except RoISError:
            raise
        except Exception as error:
            # Whoever asked learns that it failed; only the log of this process can tell where.
            _log.exception("%s: %s failed", self.profile.name, message)
            sentence = f"{self.profile.name}: {message} failed: {error}"
            self.report(ErrorType.COMPONENT_INTERNAL_ERROR, sentence)
            raise ComponentFailed(sentence) from error

    def _require_usable(self) -> None:
        status = self.status
        if status not in (ComponentStatus.READY, ComponentStatus.BUSY):
            raise ComponentFailed(f"{self.profile.name} is in status {status}")

    def _stored_parameters(self) -> tuple[Parameter, ...]:
        return tuple(
            Parameter(name=p.name, data_type_ref=p.data_type_ref.code, value=self.parameters[p.name])
            for p in self.profile.parameter_profiles
            if self.parameters[p.name]
        )

    def _set_parameters(self, arguments: tuple[Argument, ...]) -> tuple[Result, ...]:
        self.parameters.update(self.accept_parameters(check_arguments(self.profile.parameter_profiles, arguments)))
        return ()

    def accept_parameters(self, values: Arguments) -> Arguments:
        """Return what to store for values that fit their types; a subclass with more to say overrides it.

        Raises:
            BadParameter: one of them cannot be used; none is stored.
        """
        return values


def check_arguments(profiles: tuple[ParameterProfile, ...], arguments: tuple[Argument, ...]) -> dict[str, str]:
    """Return the arguments' values by name; each keeps the type of the profile, whatever type the client wrote.

    Raises:
        BadParameter: a name is unknown or repeated, or a value does not fit.
    """
    types = {profile.name: profile.data_type_ref.code for profile in profiles}
    values: dict[str, str] = {}
    for argument in arguments:
        if argument.name not in types:
            raise BadParameter(f"there is no argument {argument.name!r}; there are {', '.join(types) or 'none'}")
        if argument.name in values:
            raise BadParameter(f"the argument {argument.name!r} is given twice")
        try:
            check_value(types[argument.name], argument.value)
        except ValueError as error:
            raise BadParameter(f"{argument.name}: {error}") from None
        values[argument.name] = argument.value
    return values


def _collect(cls: type, attribute: str) -> dict[str, str]:
    marked: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        for name, function in vars(base).items():
            if hasattr(function, attribute):
                marked.update(dict.fromkeys(getattr(function, attribute), name))
    return marked


def _nobody_listens(_event_type: str, _results: tuple[Result, ...]) -> None:
    """Stand in until the component is in a registry: an event that nobody can hear is dropped."""


def _nobody_watches(_error_type: ErrorType, _description: str) -> None:
    """Stand in until the component is in a registry: nobody could be told of its fault."""
