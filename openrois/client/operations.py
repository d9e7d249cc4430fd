"""The operations of RoIS as typed methods: values come back, failures are raised."""

import secrets
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager, suppress
from typing import Any, TypeVar

from pydantic import ConfigDict

from openrois.client.application import Application
from openrois.client.commands import Command, Execution
from openrois.client.connection import Connection
from openrois.client.errors import ConnectionLost
from openrois.client.feed import BUFFER
from openrois.client.rpc_call import Outcome, ask
from openrois.client.steps import Concurrent, Step, no_step
from openrois.client.subscription import Subscription
from openrois.errors import RoISError
from openrois.types.messages import (
    CommandResultParams,
    CommandUnit,
    ComponentParams,
    ConcurrentCommands,
    ConditionParams,
    DetailParams,
    ErrorDetailParams,
    EventNotification,
    ExecuteParams,
    Parameter,
    ParametersResult,
    ProfileResult,
    QueryParams,
    ReferenceResult,
    Result,
    ResultsResult,
    ReturnResult,
    SearchResult,
    SequenceItem,
    SetParameterParams,
    SetParameterResult,
)
from openrois.types.model import Model
from openrois.types.references import engine_of
from openrois.types.streams import ConnectStreamParams, ConnectStreamResult, StreamParams

__all__ = ["Operations"]

T = TypeVar("T")
Results = tuple[Result, ...]


class Operations:
    """System, Command, Query and Event interface of one gateway (RoIS 2.0, 8.2), by the standard's names.

    Every method raises a `RoISError` for a return code other than OK, `RpcError` where the gateway does not know the
    method or its params, `ConnectionLost` and `TimeoutError`. Without a connection they wait for one, up to the request
    timeout; `set_parameter` and `execute` do not, they raise `ConnectionLost` at once: what moves a robot is not kept
    for later.
    """

    def __init__(self, connection: Connection, application: Application) -> None:
        self._connection = connection
        self._application = application
        self._commands = application.commands
        self._bindings = application.bindings
        self._subscriptions = application.subscriptions

    @property
    def extensions(self) -> frozenset[str]:
        """The gateway's extensions beyond RoIS; none where it does not know `openrois.hello`."""
        return self._application.extensions

    @property
    def generation(self) -> int:
        """A count of how often components came or went, as far as is known."""
        return self._application.generations.total

    def generation_of(self, component_ref: str) -> tuple[int, int]:
        """Return a count of the changes of a component's engine; its profile is valid for one count."""
        return self._application.generations.of(engine_of(component_ref))

    async def get_profile(self, condition: str = "") -> ProfileResult:
        """Return the tree of engines and the profile of each component that meets a condition; of all without one.

        Raises:
            BadParameter: it is no condition; see `where`.
        """
        return await self._connection.ask(
            "rois.system.get_profile", ConditionParams(condition=condition), ProfileResult
        )

    async def get_error_detail(self, error_id: str, condition: str = "") -> Results:
        """Return the details of a `Fault`.

        Args:
            error_id: of the fault.
            condition: a gateway of ours takes none but the empty one.

        Raises:
            BadParameter: the gateway does not know the fault, or does not remember it any more.
        """
        params = ErrorDetailParams(error_id=error_id, condition=condition)
        return (await self._connection.ask("rois.system.get_error_detail", params, ResultsResult)).results

    async def search(self, condition: str = "") -> tuple[str, ...]:
        """Return the references of the components that meet a condition; of all without one. See `where`."""
        params = ConditionParams(condition=condition)
        return (await self._connection.ask("rois.command.search", params, SearchResult)).component_ref_list

    async def bind(self, component_ref: str) -> None:
        """Reserve a component. It is bound again after a reconnect, until it is released.

        Raises:
            OutOfResources: another application has it.
            Unsupported: there is no such component.
        """
        async with self._bindings.turn(component_ref):
            params = ComponentParams(component_ref=component_ref)
            await self._bind_one("rois.command.bind", params, ReturnResult, lambda _result: component_ref, in_turn=True)

    async def bind_any(self, condition: str = "") -> str:
        """Reserve one of the components that meet a condition and return its reference; raises as `bind`."""
        params = ConditionParams(condition=condition)
        result = await self._bind_one(
            "rois.command.bind_any", params, ReferenceResult, lambda result: result.component_ref
        )
        return result.component_ref

    async def _bind_one(
        self,
        method: str,
        params: Model,
        model: type[Outcome],
        taken: Callable[[Outcome], str],
        *,
        in_turn: bool = False,
    ) -> Outcome:
        """Bind, and release again when the caller was cancelled meanwhile, unless another task has bound it as well."""
        used = False
        # The answer may come after the caller was cancelled, and before it has left its turn.
        has_turn = in_turn

        def accepted(result: Outcome) -> None:
            nonlocal used
            used = True
            self._bindings.use(taken(result))

        def too_late(result: Outcome) -> None:
            component_ref = taken(result)
            if used:
                unwanted = self._bindings.unuse(component_ref)
            else:
                # A task that binds it now would lose it to a release that is sent after its bind.
                is_bound_now = self._bindings.turn(component_ref).locked() and not has_turn
                unwanted = not self._bindings.wants(component_ref) and not is_bound_now
            if unwanted:
                self._bindings.gave_back(component_ref)
                self._connection.post("rois.command.release", ComponentParams(component_ref=component_ref))

        try:
            return await self._connection.ask(method, params, model, accepted=accepted, too_late=too_late)
        finally:
            has_turn = False

    async def release(self, component_ref: str) -> None:
        """Release a component; one that is not bound stays so. Without a connection it is released already."""
        self._bindings.gave_back(component_ref)
        with suppress(ConnectionLost):
            params = ComponentParams(component_ref=component_ref)
            await self._connection.act("rois.command.release", params, ReturnResult)

    @asynccontextmanager
    async def bound(self, component_ref: str) -> AsyncIterator[None]:
        """Reserve a component for as long as the block runs.

        Of blocks inside each other and in several tasks the last one gives it back; what `bind` has bound stays bound.

        Raises:
            OutOfResources: another application has it.
        """
        await self.bind(component_ref)
        try:
            yield
        finally:
            async with self._bindings.turn(component_ref):
                if self._bindings.unuse(component_ref):
                    # A component that is gone meanwhile need not be given back.
                    with suppress(RoISError, TimeoutError):
                        await self.release(component_ref)

    async def connect_stream(self, component_ref: str, parameters: Iterable[Parameter] = ()) -> str:
        """Connect a stream over the extension `rois.stream` and return its id; it is ended if the caller has gone."""

        def too_late(result: ConnectStreamResult) -> None:
            self._connection.post("rois.stream.disconnect_stream", StreamParams(stream_id=result.stream_id))

        params = ConnectStreamParams(component_ref=component_ref, parameters=tuple(parameters))
        method = "rois.stream.connect_stream"
        return (await self._connection.act(method, params, ConnectStreamResult, too_late=too_late)).stream_id

    async def get_parameter(self, component_ref: str) -> tuple[Parameter, ...]:
        """Return the parameters of a component that have a value.

        Raises:
            Unsupported: there is no such component.
        """
        params = ComponentParams(component_ref=component_ref)
        return (await self._connection.ask("rois.command.get_parameter", params, ParametersResult)).parameters

    async def set_parameter(self, component_ref: str, parameters: Iterable[Parameter]) -> Command[None]:
        """Change parameters of a component, all at once; the command that comes back ends when that is done.

        Raises:
            Unsupported: there is no such component.
            BadParameter: there is no such parameter, or a value does not fit; nothing is changed then.
            OutOfResources: the component acts, and is not bound by this application.
        """
        commands: list[Command[None]] = []

        def accepted(result: SetParameterResult) -> None:
            # `completed` may be the very next message.
            commands.append(Command(component_ref, "set_parameter", result.command_id, _nothing))
            self._commands.expect(commands)

        params = SetParameterParams(component_ref=component_ref, parameters=tuple(parameters))
        await self._connection.act("rois.command.set_parameter", params, SetParameterResult, accepted)
        return commands[0]

    async def execute(self, *items: Step[Any] | Concurrent | CommandUnit | ConcurrentCommands) -> Execution:
        """Send a sequence of commands; returns once the gateway has accepted all of them.

        Args:
            items: steps and `concurrent` steps; or units of the wire, whose `command_id`s are the caller's.

        Returns:
            The handles of the commands, in order; awaiting it waits for all.

        Raises:
            TypeError: an item is none of these.
        """
        for item in items:
            if isinstance(item, Step | Concurrent):
                item.used()
            elif not isinstance(item, CommandUnit | ConcurrentCommands):
                raise no_step("a sequence", item)
        # To prepare a step may mean to ask for a profile, and that waits for a connection: this one or none.
        session = self._connection.session("rois.command.execute")
        sequence: list[SequenceItem] = []
        commands: list[Command[Any]] = []
        for item in items:
            match item:
                case CommandUnit():
                    sequence.append(item)
                    commands.append(self._handle(item))
                case ConcurrentCommands():
                    sequence.append(item)
                    commands.extend(self._handle(unit) for unit in item.command_list)
                case Concurrent():
                    prepared = [await step.prepare(_new_id()) for step in item]
                    sequence.append(
                        ConcurrentCommands(command_list=tuple(u for u, _ in prepared), delay_time=item.delay_time)
                    )
                    commands.extend(command for _, command in prepared)
                case Step():
                    unit, command = await item.prepare(_new_id())
                    sequence.append(unit)
                    commands.append(command)
        params = ExecuteParams(command_unit_list=tuple(sequence))
        self._commands.expect(commands)
        try:
            timeout = self._connection.request_timeout
            await ask(session, "rois.command.execute", params, ReturnResult, timeout=timeout)
        except BaseException:
            self._commands.drop_commands(commands)
            raise
        return Execution(tuple(commands))

    def _handle(self, unit: CommandUnit) -> Command[Results]:
        return Command(unit.component_ref, unit.command_type, unit.command_id, self.get_command_result)

    async def run(self, *items: Step[Any] | Concurrent | CommandUnit | ConcurrentCommands) -> None:
        """Run a sequence of commands to its end: one after another, the steps of `concurrent` at the same time.

        Raises:
            RoISError: one was refused, and nothing ran; or one failed, and those after it did not run.
        """
        await (await self.execute(*items))

    async def get_command_result(self, command_id: str, condition: str = "") -> Results:
        """Return the results of a command of this application.

        Args:
            command_id: of a command that has ended.
            condition: a gateway of ours takes none but the empty one.

        Raises:
            BadParameter: the gateway does not know the command, or does not remember it any more.
        """
        params = CommandResultParams(command_id=command_id, condition=condition)
        return (await self._connection.ask("rois.command.get_command_result", params, ResultsResult)).results

    async def query(self, query_type: str, condition: str = "") -> Results:
        """Query the one component that answers a query and meets a condition.

        Raises:
            Unsupported: there is none.
            BadParameter: there are several, or it is no condition; see `where`.
        """
        params = QueryParams(query_type=query_type, condition=condition)
        return (await self._connection.ask("rois.query.query", params, ResultsResult)).results

    def subscribe(
        self, event_type: str, condition: str = "", *, buffer: int = BUFFER
    ) -> Subscription[EventNotification]:
        """Return the events of the one component that has this event and meets a condition.

        Args:
            event_type: which event.
            condition: of components; see `where`.
            buffer: how many events may wait to be read.
        """
        return self.listen(event_type, condition, _as_it_is, buffer)

    def listen(
        self, event_type: str, condition: str, read: Callable[[EventNotification], Awaitable[T]], buffer: int = BUFFER
    ) -> Subscription[T]:
        """Return what `read` makes of the events, as `subscribe`; those that it raises `ValueError` of are left out."""
        return Subscription(self._subscriptions, event_type, condition, read, buffer)

    async def get_event_detail(self, event_id: str, condition: str = "") -> Results:
        """Return the results of an event, for as long as the gateway keeps them.

        Args:
            event_id: of an event that this application has received.
            condition: a gateway of ours takes none but the empty one.

        Raises:
            BadParameter: the gateway does not know the event, or does not remember it any more.
        """
        params = DetailParams(event_id=event_id, condition=condition)
        return (await self._connection.ask("rois.event.get_event_detail", params, ResultsResult)).results

    async def call(self, method: str, /, **params: Any) -> dict[str, Any]:
        """Call any method, such as one of an extension, and return its result.

        Raises:
            RoISError: its return code is not OK.
            RpcError: the gateway does not know it, or not with these params.
            ConnectionLost: there is no connection, or it ended first.
            TimeoutError: no answer in time.
        """
        result = await self._connection.act(method, _Params.model_validate(params), _Result)
        return result.model_dump(mode="json")


def _new_id() -> str:
    """Return a new, unique command_id; without a slash it is no engine's."""
    return secrets.token_hex(16)


async def _nothing(_command_id: str) -> None:
    """Read the results of a command that has none."""


async def _as_it_is(notification: EventNotification) -> EventNotification:
    """Read the results of an event of unknown type."""
    return notification


class _Params(Model):
    """Params of any method."""

    model_config = ConfigDict(extra="allow")


class _Result(ReturnResult):
    """The result of any method."""

    model_config = ConfigDict(extra="allow")
