"""An engine at the other end of a connection, seen as a `ComponentBus`: the parent's half of the wire."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Collection
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.contract import Directory, Event, Extension, OnFault, Sink, SubscriptionLost
from openrois.errors import (
    Aborted,
    BadParameter,
    ComponentFailed,
    EngineUnreachable,
    NotResponding,
    OutOfResources,
    RoISError,
    TimedOut,
    Unsupported,
)
from openrois.interfaces.overload_rules import is_stop
from openrois.jsonrpc import protocol
from openrois.jsonrpc.session import NotificationHandler, RpcError, RpcSession
from openrois.observability.logs import Tally
from openrois.remote.attachment import ATTACHED
from openrois.remote.commands import RemoteCommand, RemoteCommands
from openrois.remote.extension import MAY_BIND, RemoteExtension
from openrois.remote.faults import RemoteFaults
from openrois.remote.followed_engines import together
from openrois.remote.greeting import Greeting
from openrois.remote.remote_directory import RemoteDirectory
from openrois.remote.remote_profile import RemoteProfile
from openrois.remote.rpc_call import RpcCalls, read_result
from openrois.remote.shared_profiles import shared_profile
from openrois.remote.stops import SharedStops
from openrois.remote.subscriptions import SharedSubscriptions
from openrois.types.codes import CompletedStatus, ReturnCode
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES
from openrois.types.messages import (
    Argument,
    CommandUnit,
    EventNotification,
    ExecuteParams,
    ParametersResult,
    ProfileResult,
    Result,
    ResultsResult,
    ReturnResult,
    SetParameterResult,
    SubscribeResult,
)
from openrois.types.reasons import ReasonNotification, sentence
from openrois.types.streams import EXTENSION_VERSION, EXTENSIONS

__all__ = ["Identity", "RemoteProxy"]

_log = logging.getLogger(__name__)

_FAILED: Final[dict[CompletedStatus, type[RoISError]]] = {
    CompletedStatus.ABORT: Aborted,
    CompletedStatus.OUT_OF_RESOURCES: OutOfResources,
    CompletedStatus.TIMEOUT: TimedOut,
}


HELLO_TIMEOUT: Final = 1.0
"""Seconds after which an engine that does not answer `openrois.hello` is taken for one of the base wire."""

READS: Final = 8
"""Times in a row that the directory of an engine is read because it has changed meanwhile."""

_READ_EVENT: Final = EventNotification.__pydantic_validator__.validate_python


@dataclass(frozen=True, slots=True)
class Identity:
    """Who an adapter is.

    Attributes:
        instance: the random text of its process; empty where it sends none.
        epoch: the greatest epoch that it has ever seen; 0 for none.
    """

    instance: str = field(default="", repr=False)
    epoch: int = 0


class RemoteProxy:
    """The five methods, called over an `RpcSession` that its owner runs.

    Args:
        session: the connection. Its `notifications` have to hold this proxy's `notifications()`.
        profile_changed: called when the other side says that its tree changed; must not block.
        tasks: owns the questions that follow from what the other side tells, and stops that several wait for.

    Attributes:
        admit: called with what the other side offers; raises where it may not offer that here, or not now.
        speaks_extensions: whether the other side has accepted a hello.
    """

    def __init__(self, session: RpcSession, profile_changed: Callable[[], None], tasks: TaskScope) -> None:
        self.extension: Extension | None = None
        self._session = session
        self._profile_changed = profile_changed
        self._calls = RpcCalls(session)
        self._remote_profile = RemoteProfile()
        self._remote_extension = RemoteExtension(
            self._calls.ask_unread, session.post, session.notify, self._remote_profile.is_own, session.outbox, tasks
        )
        self._remote_directory = RemoteDirectory(self._calls, self._take_changes)
        self._faults = RemoteFaults(partial(_error_details, self._calls), self._remote_profile, tasks)
        self._commands = RemoteCommands(self._remote_extension.catch_up)
        self._stops = SharedStops(lambda ref, wanted, accepted: self._run(ref, "stop", (), wanted, accepted), tasks)
        self._subscriptions = SharedSubscriptions(self._subscribe, self._unsubscribe, self._drop_subscription)
        self._strays = Tally(_log, "events that do not fit their subscription")
        self._is_plain = False
        self._is_reading = False
        """Whether the directory is read, again and again while it changes."""
        self._greeting: Greeting | None = None
        self.admit: Callable[[Directory], Awaitable[None]] = _admit
        self.speaks_extensions = False

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the notifications that come over the connection."""
        return {
            "rois.command.completed": self._commands.handle_completed,
            ReasonNotification.method: self._take_reason,
            "rois.event.notify_event": self._take_event,
            "rois.system.profile_changed": lambda _params: self._take_changes(None),
            "rois.system.notify_error": self._faults.handle_notification,
            **self._remote_directory.notifications(),
            **self._remote_extension.notifications(),
        }

    @property
    def on_fault(self) -> OnFault:
        """The function that gets the faults of the other side."""
        return self._faults.on_fault

    @on_fault.setter
    def on_fault(self, on_fault: OnFault) -> None:
        self._faults.on_fault = on_fault

    @property
    def engine_ids(self) -> tuple[str, ...]:
        """The ids of the other side's engines, as far as they are known."""
        directory = self._remote_profile.directory
        return () if directory is None else directory.profile.engine_ids()

    @property
    def identity(self) -> Identity:
        """Who the other side is, as far as it says so."""
        greeting = self._greeting
        return Identity() if greeting is None else Identity(greeting.instance, greeting.epoch)

    async def discover(self) -> Directory:
        """Ask for the other side's extensions, unless it seems to have none, and read its directory or profile."""
        if not self._is_plain:
            await self._greet()
        directory, streaming = await (self._read_directory() if self._has_directory else self._read_profile())
        self._use_greeting(streaming)
        await self.admit(directory)
        self._remote_profile.directory = directory
        self._subscriptions.keep_only(directory.component_profiles, SubscriptionLost("the component is gone"))
        return directory

    @property
    def _has_directory(self) -> bool:
        """Whether the other side has said that it has a directory, and notifies of its changes."""
        return not self._is_plain and self._greeting is not None and DIRECTORY in self._greeting.extensions

    async def _read_profile(self) -> tuple[Directory, frozenset[str]]:
        """Return the other side's whole profile, and which of its engines have streams."""
        result = await self._calls.ask("rois.system.get_profile", {"condition": ""}, ProfileResult)
        if result.profile is None:
            raise ComponentFailed("the engine has no profile")
        # It speaks for the components that it lists: another profile could belong to another engine.
        listed = {ref: result.component_profiles.get(ref) for ref in result.profile.component_refs()}
        profiles = {ref: shared_profile(profile) for ref, profile in listed.items() if profile is not None}
        streaming = frozenset[str]()
        if self._greeting is not None and "rois.stream" in self._greeting.extensions:
            named = self._greeting.engines or (result.profile.identifier.code,)
            streaming = frozenset(named).intersection(result.profile.engine_ids())
        return Directory(result.profile, profiles), streaming

    async def _read_directory(self) -> tuple[Directory, frozenset[str]]:
        """Return the same by the other side's directory: what is as it was is not read again."""
        remote = self._remote_directory
        self._is_reading = True
        try:
            for _ in range(READS):
                await remote.read()
                if remote.is_settled:
                    break
        finally:
            self._is_reading = False
        if remote.engines.main is None:
            raise ComponentFailed("the directory of the engine changes faster than it can be listed")
        if not remote.is_settled:
            self._profile_changed()
        return together(remote.engines.main, remote.engines.roots.values()), remote.engines.streaming()

    async def _greet(self) -> None:
        params = {"version": EXTENSION_VERSION, "extensions": [*EXTENSIONS, DIRECTORY, LEASES, ATTACHED]}
        timeout = min(HELLO_TIMEOUT, self._session.call_timeout)
        try:
            self._greeting = await self._calls.ask(
                "openrois.hello", params, Greeting, too_late=self._take_late_greeting, timeout=timeout
            )
        except Unsupported:
            self._is_plain = True
        except NotResponding:
            # It may speak the base wire alone, and answer what it does not know with nothing.
            self._is_plain = self._greeting is None
        except ComponentFailed as error:
            self._is_plain = isinstance(error.__cause__, RpcError) and error.__cause__.code == protocol.METHOD_NOT_FOUND
            if not self._is_plain:
                raise

    def _take_late_greeting(self, result: Any) -> None:
        greeting = read_result("openrois.hello", result, Greeting)
        former = self._greeting
        if greeting.return_code is not ReturnCode.OK or greeting == former:
            return
        self._greeting, self._is_plain = greeting, False
        # Epochs grow all the time, and are no reason for another look.
        if former is None or greeting.model_copy(update={"epoch": former.epoch}) != former:
            self._profile_changed()

    def _use_greeting(self, streaming: frozenset[str]) -> None:
        greeting = None if self._is_plain else self._greeting
        self.speaks_extensions = greeting is not None
        if greeting is None:
            self.extension = None
            return
        has_extension = "rois.stream" in greeting.extensions or LEASES in greeting.extensions
        self.extension = self._remote_extension if has_extension else None
        self._remote_extension.takes_may_bind = MAY_BIND in greeting.extensions
        self._remote_extension.limit_to(streaming)

    async def query(self, component_ref: str, query_type: str) -> tuple[Result, ...]:
        """Query a component."""
        if query_type == "get_parameter":
            params: dict[str, Any] = {"component_ref": component_ref}
            stored = (await self._calls.ask("rois.command.get_parameter", params, ParametersResult)).parameters
            self._remote_profile.note(component_ref, "parameters", query_type, stored)
            return stored
        params = {"query_type": query_type, "condition": _only(component_ref)}
        results = (await self._calls.ask("rois.query.query", params, ResultsResult)).results
        self._remote_profile.note(component_ref, "query", query_type, results)
        return results

    async def invoke(
        self, component_ref: str, command_type: str, arguments: tuple[Argument, ...] = (), command_id: str = ""
    ) -> tuple[Result, ...]:
        """Run a command and wait until the other side has notified its end; a `stop` may be shared with others."""
        if not is_stop(command_type):
            return await self._run(component_ref, command_type, arguments, command_id)
        self._commands.stop(component_ref)
        if arguments:
            # A stop that is not shared waits for room as any other command.
            return await self._run(component_ref, command_type, arguments, command_id)
        return await self._stops.join(component_ref, command_id)

    async def _run(
        self,
        component_ref: str,
        command_type: str,
        arguments: tuple[Argument, ...],
        wanted: str,
        accepted: Callable[[], None] | None = None,
    ) -> tuple[Result, ...]:
        """Run a command, if possible under the id that is wanted; one with `accepted`, called then, is urgent."""
        command = RemoteCommand(component_ref)
        self._commands.wait(command)
        try:
            if accepted is None:
                await self._stops.sent(component_ref)
            if command_type == "set_parameter":
                await self._set_parameter(component_ref, arguments, command)
            else:
                unit = CommandUnit(
                    component_ref=component_ref, command_type=command_type, command_id=wanted, arguments=arguments
                )
                await self._execute(unit, command, is_urgent=accepted is not None)
            if accepted is not None:
                accepted()
            # The component's own engine ends it in time, and can say more about it; some do not.
            promised = self._remote_profile.seconds_for(component_ref, command_type)
            async with asyncio.timeout(None if promised is None else promised + self._session.call_timeout):
                status = await command.ended
        except TimeoutError:
            raise NotResponding(f"{command_type} of {component_ref} did not end in time") from None
        finally:
            self._commands.forget_command(command)
        if status is None:
            raise EngineUnreachable(f"the connection to the engine was lost during {command_type} of {component_ref}")
        if status is not CompletedStatus.OK:
            raise _failure(status, command.reason or "its adapter gives no reason, but its log may")
        return await self._command_results(component_ref, command_type, command.command_id)

    async def _execute(self, unit: CommandUnit, command: RemoteCommand, *, is_urgent: bool) -> None:
        """Send a unit under its id, or under another where it is taken or such ids are the other side's to choose."""
        wanted = "" if self._remote_profile.is_own(unit.command_id) else unit.command_id
        try:
            await self._execute_as(self._commands.id_for(wanted), unit, command, is_urgent)
        except BadParameter:
            if command.command_id != wanted:
                raise
            # The other side may remember the id from before this connection.
            self._commands.forget_command(command)
            if is_urgent:
                command.is_stopped = False
            await self._execute_as(self._commands.id_for(wanted), unit, command, is_urgent)

    async def _execute_as(self, command_id: str, unit: CommandUnit, command: RemoteCommand, is_urgent: bool) -> None:
        self._commands.expect(command_id, command)
        await self._calls.ask(
            "rois.command.execute",
            ExecuteParams(command_unit_list=(unit.model_copy(update={"command_id": command_id}),)),
            ReturnResult,
            urgent=is_urgent,
            before=partial(self._commands.send, command),
        )

    async def _set_parameter(self, component_ref: str, arguments: tuple[Argument, ...], command: RemoteCommand) -> None:
        def accepted(result: SetParameterResult) -> None:
            # The id is the other side's: it is known from here on, before its `completed` can be read.
            self._remote_profile.require_own(result.command_id)
            if result.command_id in self._commands:
                raise ComponentFailed(f"the engine minted the id {result.command_id[:200]!r} twice")
            self._commands.expect(result.command_id, command)

        params = {
            "component_ref": component_ref,
            "parameters": [argument.model_dump(mode="json") for argument in arguments],
        }
        before = partial(self._commands.send, command)
        await self._calls.ask("rois.command.set_parameter", params, SetParameterResult, accepted, before=before)

    async def _command_results(self, component_ref: str, command_type: str, command_id: str) -> tuple[Result, ...]:
        profile = self._remote_profile.profile(component_ref)
        command = profile.command(command_type) if profile is not None else None
        if command is None or not command.results:
            return ()
        params = {"command_id": command_id, "condition": ""}
        results = (await self._calls.ask("rois.command.get_command_result", params, ResultsResult)).results
        self._remote_profile.note(component_ref, "command", command_type, results)
        return results

    async def subscribe(self, component_ref: str, event_type: str, sink: Sink) -> str:
        """Subscribe to a component; several subscriptions to one event share one on the other side."""
        self._calls.require_connected()
        return await self._subscriptions.add((component_ref, event_type), sink)

    async def unsubscribe(self, subscribe_id: str) -> None:
        """End a subscription."""
        await self._subscriptions.remove(subscribe_id)

    async def _subscribe(self, key: tuple[str, str], register: Callable[[str], None]) -> None:
        component_ref, event_type = key

        def accepted(result: SubscribeResult) -> None:
            self._remote_profile.require_own(result.subscribe_id)
            register(result.subscribe_id)

        def too_late(result: Any) -> None:
            self._drop_subscription(read_result("rois.event.subscribe", result, SubscribeResult).subscribe_id)

        params = {"event_type": event_type, "condition": _only(component_ref)}
        await self._calls.ask("rois.event.subscribe", params, SubscribeResult, accepted, too_late)

    async def _unsubscribe(self, remote_id: str) -> None:
        if not self._calls.lost:
            await self._calls.ask("rois.event.unsubscribe", {"subscribe_id": remote_id}, ReturnResult)

    def _drop_subscription(self, remote_id: str) -> None:
        if remote_id:
            self._session.post("rois.event.unsubscribe", {"subscribe_id": remote_id})

    def lost(self, reason: str) -> None:
        """End everything with the connection: what waits fails, and every subscriber is notified, once."""
        self._calls.lost = True
        self.extension = None
        self._commands.lost()
        self._subscriptions.lost(SubscriptionLost(reason))
        self._remote_extension.lost()

    def _take_changes(self, engine_ids: Collection[str] | None) -> None:
        self._subscriptions.tree_changed(engine_ids)
        if not self._is_reading:
            self._profile_changed()

    def _take_reason(self, params: dict[str, Any]) -> None:
        notice = ReasonNotification.model_validate(params)
        line = sentence(notice.reason)
        self._session.handle_reason(notice.request_id, line)
        if notice.command_id is not None:
            self._commands.take_reason(notice.command_id, line)

    def _take_event(self, params: dict[str, Any]) -> None:
        notice: EventNotification = _READ_EVENT(params)
        key = self._subscriptions.key_of(notice.subscribe_id)
        if key is None:
            return
        component_ref, event_type = key
        if notice.event_type != event_type or not self._remote_profile.is_own(notice.event_id):
            self._strays.note(f"one of type {notice.event_type[:80]!r} for a subscription to {event_type!r}")
            return
        self._remote_profile.note(component_ref, "event", event_type, notice.results)
        event = Event(notice.event_id, event_type, component_ref, notice.expire, notice.results)
        self._subscriptions.emit(key, event)


async def _admit(_directory: Directory) -> None:
    """Admit whatever is offered."""


async def _error_details(asking: RpcCalls, error_id: str) -> ResultsResult:
    params = {"error_id": error_id, "condition": ""}
    return await asking.ask("rois.system.get_error_detail", params, ResultsResult)


def _failure(status: CompletedStatus, message: str) -> RoISError:
    return _FAILED.get(status, ComponentFailed)(message)


def _only(component_ref: str) -> str:
    quoted = component_ref.replace("'", "''")
    return f"component_ref = '{quoted}'"
