"""The methods of an application at its gateway: each request goes to the gateway that owns the engine it is about."""

import logging
from asyncio import gather
from collections.abc import Callable, Mapping
from typing import Any, Final

from pydantic import ValidationError

from openrois.auth.principal import Principal
from openrois.engine.condition import parse_condition
from openrois.errors import BadParameter, EngineUnreachable, OutOfResources, RoISError, Unsupported
from openrois.federation.assertion import Assertion
from openrois.federation.destinations import OF_ENGINE, command_ids, engine_named, engines_commanded, only_stops
from openrois.federation.federation import Federation
from openrois.federation.foreign_work import ForeignWork
from openrois.federation.sub_session import SubSession
from openrois.federation.sub_sessions import PRINCIPAL, SubSessions
from openrois.interfaces import directory_methods
from openrois.interfaces.query import FAILING, STATUS_QUERY
from openrois.interfaces.selection import COMPONENT_PROPERTIES, found_by, observed_component, queried_component
from openrois.interfaces.system import profile_of
from openrois.jsonrpc.session import Handler, Reply
from openrois.scope.scoped_tree import ScopedTree
from openrois.scope.views import ViewChange
from openrois.session.change_notice import ChangeNotice
from openrois.session.session import ApplicationSession
from openrois.session.stream_parameters import lost_streams
from openrois.transport.stream import StreamClosed
from openrois.types.codes import CompletedStatus, ErrorType, ReturnCode
from openrois.types.directory import DIRECTORY, DirectoryChangedNotification
from openrois.types.leases import StopAllParams, StopAllResult
from openrois.types.messages import (
    ConditionParams,
    QueryParams,
    ReferenceResult,
    ResultsResult,
    ReturnResult,
    SearchResult,
    SubscribeParams,
)
from openrois.types.methods import METHODS
from openrois.types.references import engine_of
from openrois.types.streams import HelloParams, HelloResult

__all__ = ["Router", "without_directory"]

_log = logging.getLogger(__name__)

LEAVING_TIMEOUT: Final = 1.0
"""Seconds that another gateway has to confirm that an application has disconnected."""

_RESULTS: Final = {method.name: method.result for method in METHODS}
_OF_DIRECTORY: Final = frozenset({"rois.system.profile_changed", DirectoryChangedNotification.method})


def without_directory(notify: Callable[..., None]) -> Callable[..., None]:
    """Return a function for the notifications of a session whose engines are a part of those that a `Router` shows."""

    def pass_on(method: str, params: Any, **more: bool) -> None:
        if method not in _OF_DIRECTORY:
            notify(method, params, **more)

    return pass_on


class Router:
    """One application of a gateway of a cluster.

    What is about an engine of another gateway goes to a session there; all else goes to the session here.

    Args:
        federation: the gateway among the others of its cluster.
        app: the session at the engines of this gateway.
        local: its methods.
        notify: sends the application a notification.
        address: where the application comes from.

    Attributes:
        engine: all engines of the cluster that the application sees.
        change_notice: notifies of changes of the directory.
    """

    def __init__(
        self,
        federation: Federation,
        app: ApplicationSession,
        local: Mapping[str, Handler],
        notify: Callable[..., None],
        address: str,
    ) -> None:
        self.engine = ScopedTree(federation.directory, app.principal, federation.views)
        self.change_notice = ChangeNotice(notify, lambda engine_id: self.engine.tree.has_engine(engine_id))
        self._federation = federation
        self._app = app
        self._local = local
        self._notify = notify
        self._address = address
        self._work = ForeignWork()
        self._subs = SubSessions(
            federation.dial, app.host.tasks, self._assertion, notify, self._work.note_notification, self._handle_loss
        )
        self._stop_listening = self.engine.on_change(self._tree_changed)

    def _assertion(self) -> Assertion:
        return Assertion.of(self._app.principal, address=self._address)

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether the application sees an engine that has the streaming methods."""
        return self.engine.tree.has_engine(engine_id) and self._federation.directory.has_streams(engine_id)

    @property
    def principal(self) -> Principal:
        """The principal of the application; another one takes its place here and at all gateways."""
        return self._app.principal

    @principal.setter
    def principal(self, principal: Principal) -> None:
        self._app.principal = principal
        self.engine.principal = principal
        self._subs.tell(PRINCIPAL, self._assertion().hello())

    def _tree_changed(self, change: ViewChange) -> None:
        if change.visible:
            self.change_notice.changed(change.engine_ids)

    async def close(self, *, lost: bool) -> None:
        """End the sessions at other gateways.

        Args:
            lost: the connection of the application was lost.
        """
        self._stop_listening()
        self.change_notice.close()
        self.engine.close()
        await self._subs.close(lost=lost)

    def methods(self) -> dict[str, Handler]:
        """Return the methods of the application, in the place of those of its session here."""
        table: dict[str, Handler] = {
            **{name: self._leading(name) for name in OF_ENGINE},
            "rois.command.set_parameter": self._set_parameter,
            "rois.command.execute": self._execute,
            "rois.command.search": self._search,
            "rois.command.bind_any": self._bind_any,
            "rois.command.get_command_result": self._get_command_result,
            "rois.query.query": self._query,
            "rois.event.subscribe": self._subscribe,
            "rois.stream.connect_stream": self._connect_stream,
            "rois.system.connect": self._connect,
            "rois.system.disconnect": self._disconnect,
            "rois.system.get_profile": self._get_profile,
            "rois.system.get_error_detail": self._get_error_detail,
            "openrois.hello": self._hello,
            "openrois.lease.grant": self._answering("openrois.lease.grant"),
            "openrois.lease.decline": self._answering("openrois.lease.decline"),
            "openrois.stop_all": self._stop_all,
        }
        refusing = {name: _refusing(name, handler) for name, handler in table.items()}
        return {**self._local, **directory_methods(self), **refusing}

    # Where a request goes.

    def _gateway(self, engine_id: str, component_ref: object = None) -> str | None:
        """Return the other gateway that owns an engine; None where the session here answers.

        Raises:
            EngineUnreachable: the application would see the component that is named, and its gateway is not reached.
        """
        if self.engine.tree.has_engine(engine_id):
            gateway_id = self._federation.directory.gateway_of(engine_id)
            return None if gateway_id == self._federation.gateway_id else gateway_id
        if isinstance(component_ref, str) and self.engine.sees(component_ref):
            self._federation.require_reachable(engine_id)
        return None

    async def _sub(self, engine_id: str, component_ref: object = None) -> SubSession | None:
        gateway_id = self._gateway(engine_id, component_ref)
        return None if gateway_id is None else await self._subs.to(gateway_id)

    def _leading(self, name: str) -> Handler:
        is_urgent = name == "rois.command.release"

        async def lead(params: dict[str, Any]) -> Any:
            component_ref = params.get("component_ref")
            sub = await self._sub(engine_named(name, params), component_ref)
            if sub is None:
                return await self._local[name](params)
            if isinstance(component_ref, str):
                sub.note_ref(component_ref)
            return await sub.relay(name, params, urgent=is_urgent)

        return lead

    async def _query(self, params: dict[str, Any]) -> Any:
        try:
            asked = QueryParams.model_validate(params)
        except ValidationError:
            return await self._local["rois.query.query"](params)
        if asked.query_type == STATUS_QUERY:
            component_ref = parse_condition(asked.condition, COMPONENT_PROPERTIES).value_of("component_ref")
            if component_ref is not None and self._has_lost(component_ref):
                return ResultsResult(results=(FAILING,))
        component_ref = queried_component(self.engine, asked.query_type, asked.condition)
        return await self._lead_to(component_ref, "rois.query.query", params)

    def _has_lost(self, component_ref: str) -> bool:
        return component_ref in self._federation.directory.lost and self.engine.sees(component_ref)

    async def _subscribe(self, params: dict[str, Any]) -> Any:
        try:
            asked = SubscribeParams.model_validate(params)
        except ValidationError:
            return await self._local["rois.event.subscribe"](params)
        component_ref = observed_component(self.engine, asked.event_type, asked.condition)
        return await self._lead_to(component_ref, "rois.event.subscribe", params)

    async def _lead_to(self, component_ref: str, name: str, params: dict[str, Any]) -> Any:
        sub = await self._sub(engine_of(component_ref), component_ref)
        if sub is None:
            return await self._local[name](params)
        sub.note_ref(component_ref)
        return await sub.relay(name, params)

    # Commands.

    async def _execute(self, params: dict[str, Any]) -> Any:
        name = "rois.command.execute"
        commands = command_ids(params)
        named = {engine_id: self._gateway(engine_id) for engine_id in engines_commanded(params)}
        gateways = set(named.values())
        if len(gateways) > 1:
            engines = ", ".join(sorted(named))
            raise BadParameter(f"{engines} are at different gateways: send a sequence to each of them")
        for engine_id in named:
            self._gateway(engine_id, next((ref for ref in commands.values() if engine_of(ref) == engine_id), None))
        gateway_id = gateways.pop() if gateways else None
        if gateway_id is None:
            taken = next((each for each in commands if each in self._work), None)
            if taken is not None:
                raise BadParameter(f"the command_id {taken[:200]!r} is empty or taken")
            return await self._local[name](params)
        taken = next((each for each in commands if each in self._app.commands), None)
        if taken is not None:
            raise BadParameter(f"the command_id {taken[:200]!r} is empty or taken")
        sub = await self._subs.to(gateway_id)
        self._work.begin(gateway_id, commands)
        is_accepted = False

        def note(result: Mapping[str, Any]) -> None:
            nonlocal is_accepted
            is_accepted = result.get("return_code") == ReturnCode.OK.value

        for ref in commands.values():
            sub.note_ref(ref)
        try:
            return await sub.relay(name, params, urgent=only_stops(params), accepted=note)
        finally:
            if not is_accepted:
                self._work.give_up(commands)

    async def _set_parameter(self, params: dict[str, Any]) -> Any:
        name, component_ref = "rois.command.set_parameter", params.get("component_ref")
        sub = await self._sub(engine_named(name, params), component_ref)
        if sub is None:
            return await self._local[name](params)

        def note(result: Mapping[str, Any]) -> None:
            command_id = result.get("command_id")
            if result.get("return_code") == ReturnCode.OK.value and isinstance(command_id, str):
                self._work.begin(sub.gateway_id, {command_id: str(component_ref)})

        return await sub.relay(name, params, accepted=note)

    async def _get_command_result(self, params: dict[str, Any]) -> Any:
        name, command_id = "rois.command.get_command_result", params.get("command_id")
        gateway_id = self._work.gateway_of_command(command_id) if isinstance(command_id, str) else None
        if gateway_id is None:
            return await self._local[name](params)
        return await (await self._subs.to(gateway_id)).relay(name, params)

    async def _search(self, params: dict[str, Any]) -> Any:
        asked = _read(ConditionParams, params)
        if asked is None:
            return await self._local["rois.command.search"](params)
        return SearchResult(component_ref_list=tuple(found_by(self.engine.tree, asked.condition)))

    async def _bind_any(self, params: dict[str, Any]) -> Any:
        """Bind one at the first gateway that has a free one, in the order in which the components are found."""
        name, asked = "rois.command.bind_any", _read(ConditionParams, params)
        if asked is None:
            return await self._local[name](params)
        refs = found_by(self.engine.tree, asked.condition)
        if not refs:
            raise Unsupported("no component satisfies the condition")
        for gateway_id in dict.fromkeys(self._gateway(engine_of(ref)) for ref in refs):
            if gateway_id is None:
                reply = await self._local[name](params)
                result = reply.result if isinstance(reply, Reply) else reply
                if result.return_code is ReturnCode.OK:
                    return reply
                continue
            try:
                sub = await self._subs.to(gateway_id)
                found, _ = await sub.ask(name, params)
            except EngineUnreachable as error:
                _log.info("bind_any goes on elsewhere: %s", error)
                continue
            if found.get("return_code") == ReturnCode.OK.value:
                sub.note_ref(str(found.get("component_ref")))
                return ReferenceResult.model_validate(found)
        raise OutOfResources("every component that satisfies the condition is bound by another application")

    # Streams, leases, STOP.

    async def _connect_stream(self, params: dict[str, Any]) -> Any:
        name, component_ref = "rois.stream.connect_stream", params.get("component_ref")
        sub = await self._sub(engine_named(name, params), component_ref)
        if sub is None:
            return await self._local[name](params)
        self._app.extended = True

        def note(result: Mapping[str, Any]) -> None:
            stream_id = result.get("stream_id")
            if isinstance(stream_id, str) and stream_id:
                self._work.note_stream(sub.gateway_id, stream_id, str(component_ref))

        sub.note_ref(str(component_ref))
        return await sub.relay(name, params, accepted=note)

    def _answering(self, name: str) -> Handler:
        async def answer(params: dict[str, Any]) -> Any:
            request_id = params.get("request_id")
            gateway_id = self._work.gateway_of_request(request_id) if isinstance(request_id, str) else None
            if gateway_id is None:
                return await self._local[name](params)
            return await (await self._subs.to(gateway_id)).relay(name, params)

        return answer

    async def _stop_all(self, params: dict[str, Any]) -> Any:
        name, asked = "openrois.stop_all", _read(StopAllParams, params)
        if asked is None or (asked.engine_id is not None and asked.component_ref is not None):
            return await self._local[name](params)
        engine_id = asked.engine_id or engine_of(asked.component_ref or "")
        if engine_id:
            sub = await self._sub(engine_id, asked.component_ref or f"{engine_id}/")
            return await (self._local[name](params) if sub is None else sub.relay(name, params, urgent=True))
        return await self._stop_everything(params)

    async def _stop_everything(self, params: dict[str, Any]) -> Reply:
        """Stop what the application controls at each gateway; an administrator controls all that it sees."""
        name, gateways = "openrois.stop_all", {sub.gateway_id for sub in self._subs.open}
        if self._app.principal.is_administrator:
            gateways |= {origin.gateway_id for origin in self.engine.tree.buses()} - {self._federation.gateway_id}

        async def stop_at(gateway_id: str) -> tuple[StopAllResult, str]:
            try:
                result, reason = await (await self._subs.to(gateway_id)).ask(name, params, urgent=True)
                return StopAllResult.model_validate(result), reason
            except (RoISError, ValidationError) as error:
                return StopAllResult(return_code=ReturnCode.ERROR), f"gateway {gateway_id} was not stopped: {error}"

        async def stop_here() -> tuple[StopAllResult, str]:
            reply = await self._local[name](params)
            return (reply.result, reply.reason) if isinstance(reply, Reply) else (reply, "")

        outcomes = await gather(stop_here(), *(stop_at(gateway_id) for gateway_id in sorted(gateways)))
        is_done = all(result.return_code is ReturnCode.OK for result, _ in outcomes)
        result = StopAllResult(
            return_code=ReturnCode.OK if is_done else ReturnCode.ERROR,
            stopped=tuple(ref for result, _ in outcomes for ref in result.stopped),
            failed=tuple(ref for result, _ in outcomes for ref in result.failed),
        )
        return Reply(result, reason="; ".join(reason for _, reason in outcomes if reason))

    # The system.

    async def _hello(self, params: dict[str, Any]) -> Any:
        said = await self._local["openrois.hello"](params)
        result = said.result if isinstance(said, Reply) else said
        if not isinstance(result, HelloResult) or result.return_code is not ReturnCode.OK:
            return said
        self._subs.say("openrois.hello", params)
        if DIRECTORY in HelloParams.model_validate(params).extensions:
            self.change_notice.name_engines()
            return result
        seen = self._federation.directory.streaming & self.engine.tree.engine_ids
        return result.model_copy(update={"engines": tuple(sorted(seen))})

    async def _connect(self, params: dict[str, Any]) -> Any:
        self._subs.say("rois.system.connect", {})
        return await self._local["rois.system.connect"](params)

    async def _disconnect(self, params: dict[str, Any]) -> Any:
        self._subs.unsay("rois.system.connect")

        async def leave(sub: SubSession) -> None:
            try:
                await sub.ask("rois.system.disconnect", {}, timeout=LEAVING_TIMEOUT, urgent=True)
            except RoISError as error:
                # What it had there ends as that of a lost connection.
                _log.info("an application could not leave in good order: %s", error)
                sub.abort()

        await gather(*(leave(sub) for sub in self._subs.open))
        return await self._local["rois.system.disconnect"](params)

    async def _get_profile(self, params: dict[str, Any]) -> Any:
        asked = _read(ConditionParams, params)
        if asked is None:
            return await self._local["rois.system.get_profile"](params)
        self.change_notice.flush()
        return profile_of(self.engine.tree, asked)

    async def _get_error_detail(self, params: dict[str, Any]) -> Any:
        name, error_id = "rois.system.get_error_detail", params.get("error_id")
        engine_id = engine_of(error_id) if isinstance(error_id, str) else ""
        gateway_id = self._gateway(engine_id)
        if gateway_id is not None:
            return await (await self._subs.to(gateway_id)).relay(name, params)
        reply = await self._local[name](params)
        if engine_id != self.engine.tree.engine_id or not isinstance(reply, Reply):
            return reply
        for sub in self._subs.open:
            # A fault of the main engine may have been noticed by any gateway.
            found, _ = await sub.ask(name, params)
            if found.get("return_code") == ReturnCode.OK.value:
                return found
        return reply

    # What is lost with a gateway.

    def _handle_loss(self, sub: SubSession, closed: StreamClosed) -> None:
        app, lost = self._app, self._work.lose(sub.gateway_id)
        reason = f"gateway {sub.gateway_id}, which has the engine, was lost: {closed}"
        for notice in lost_streams(lost.streams, {}, app.host.wall_clock()):
            if app.extended:
                self._notify(notice.method, notice.model_dump(mode="json"))
        for command_id in lost.commands:
            app.completed(command_id, CompletedStatus.ERROR, reason)
        refs = [ref for ref in sub.refs if self.engine.sees(ref)]
        for fault in app.host.engine.mint.make_each(ErrorType.COMPONENT_NOT_RESPONDING, refs, reason):
            app.tell_fault(fault)


def _refusing(name: str, handler: Handler) -> Handler:
    """Return a handler that answers a failure in RoIS terms as an operation does."""

    async def answer(params: dict[str, Any]) -> Any:
        try:
            return await handler(params)
        except RoISError as error:
            _log.debug("%s: %s", name, error)
            return Reply(_RESULTS.get(name, ReturnResult)(return_code=error.return_code), reason=str(error))

    return answer


def _read(model: Any, params: dict[str, Any]) -> Any:
    """Return params that fit; None where the session here says what is wrong with them."""
    try:
        return model.model_validate(params)
    except ValidationError:
        return None
