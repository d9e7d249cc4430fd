"""An engine at the other end of a connection, seen as a `ComponentBus`: the parent's half of the wire."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Collection
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
)
from openrois.interfaces.overload_rules import is_stop
from openrois.jsonrpc.session import NotificationHandler, RpcSession
from openrois.observability.logs import Tally
from openrois.remote.commands import RemoteCommand, RemoteCommands
from openrois.remote.extension import MAY_BIND, VISITORS, RemoteExtension
from openrois.remote.faults import RemoteFaults
from openrois.remote.remote_offer import Identity, RemoteOffer
from openrois.remote.remote_profile import RemoteProfile
from openrois.remote.rpc_call import RpcCalls, read_result
from openrois.remote.stops import SharedStops
from openrois.remote.subscriptions import SharedSubscriptions
from openrois.types.codes import CompletedStatus
from openrois.types.leases import LEASES
from openrois.types.messages import (
    Argument,
    CommandUnit,
    EventNotification,
    ExecuteParams,
    ParametersResult,
    Result,
    ResultsResult,
    ReturnResult,
    SetParameterResult,
    SubscribeResult,
)
from openrois.types.reasons import ReasonNotification, sentence
from openrois.types.stops import StoppedNotification

__all__ = ["RemoteProxy"]

_log = logging.getLogger(__name__)

_FAILED: Final[dict[CompletedStatus, type[RoISError]]] = {
    CompletedStatus.ABORT: Aborted,
    CompletedStatus.OUT_OF_RESOURCES: OutOfResources,
    CompletedStatus.TIMEOUT: TimedOut,
}


class RemoteProxy:
    """The five methods, called over an `RpcSession` that its owner runs.

    Args:
        session: the connection. Its `notifications` have to hold this proxy's `notifications()`.
        profile_changed: called when the other side says that its tree changed; must not block.
        tasks: owns the questions that follow from what the other side tells, and stops that several wait for.

    Attributes:
        on_stopped: called when the other side says that a person has stopped one of its engines, or handed it back.
        admit: called with what the other side offers; raises where it may not offer that here, or not now.
        speaks_extensions: whether the other side has accepted a hello.
    """

    def __init__(self, session: RpcSession, profile_changed: Callable[[], None], tasks: TaskScope) -> None:
        self.extension: Extension | None = None
        self._session = session
        self._calls = RpcCalls(session)
        self._remote_profile = RemoteProfile()
        self._remote_extension = RemoteExtension(
            self._calls.ask_unread, session.post, session.notify, self._remote_profile.is_own, session.outbox, tasks
        )
        self._offer = RemoteOffer(self._calls, session.call_timeout, profile_changed, self._take_changes)
        self._faults = RemoteFaults(partial(_error_details, self._calls), self._remote_profile, tasks)
        self._commands = RemoteCommands(self._remote_extension.catch_up)
        self._stops = SharedStops(lambda ref, wanted, accepted: self._run(ref, "stop", (), wanted, accepted), tasks)
        self._subscriptions = SharedSubscriptions(self._subscribe, self._unsubscribe, self._drop_subscription)
        self._strays = Tally(_log, "events that do not fit their subscription")
        self.on_stopped: Callable[[StoppedNotification], object] = lambda _notice: None
        self.admit: Callable[[Directory], Awaitable[None]] = _admit
        self.speaks_extensions = False

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the notifications that come over the connection."""
        return {
            "rois.command.completed": self._commands.handle_completed,
            ReasonNotification.method: self._take_reason,
            "rois.event.notify_event": self._take_event,
            "rois.system.notify_error": self._faults.handle_notification,
            StoppedNotification.method: self._take_stop,
            **self._offer.notifications(),
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

    def keep_stop(self, notice: StoppedNotification) -> None:
        """Notify the other side that a person has stopped an engine, or has handed it back, if it keeps that."""
        if self.identity.stopped is not None:
            self._remote_extension.put_stop(notice)

    @property
    def identity(self) -> Identity:
        """Who the other side is, as far as it says so."""
        return self._offer.identity

    async def discover(self) -> Directory:
        """Read what the other side offers."""
        directory, streaming = await self._offer.read()
        self._use_greeting(streaming)
        await self.admit(directory)
        self._remote_profile.directory = directory
        self._subscriptions.keep_only(directory.component_profiles, SubscriptionLost("the component is gone"))
        return directory

    def _use_greeting(self, streaming: frozenset[str]) -> None:
        greeting = self._offer.greeting
        self.speaks_extensions = greeting is not None
        if greeting is None:
            self.extension = None
            return
        has_extension = "rois.stream" in greeting.extensions or LEASES in greeting.extensions
        self.extension = self._remote_extension if has_extension else None
        self._remote_extension.takes_may_bind = MAY_BIND in greeting.extensions
        self._remote_extension.takes_role = VISITORS in greeting.extensions
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

    def _take_reason(self, params: dict[str, Any]) -> None:
        notice = ReasonNotification.read_newer(params)
        line = sentence(notice.reason)
        self._session.handle_reason(notice.request_id, line)
        if notice.command_id is not None:
            self._commands.take_reason(notice.command_id, line)

    def _take_stop(self, params: dict[str, Any]) -> None:
        notice = StoppedNotification.read_newer(params)
        if notice.engine_id in self.engine_ids:
            self.on_stopped(notice)

    def _take_event(self, params: dict[str, Any]) -> None:
        notice = EventNotification.read_newer(params)
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
