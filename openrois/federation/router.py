"""The methods of an application at its gateway: each request goes to the gateway that owns the engine it is about."""

import logging
from collections.abc import Awaitable, Callable, Iterator, Mapping
from functools import partial
from typing import Any, Final

from openrois.auth.principal import Principal
from openrois.engine.condition import parse_condition
from openrois.errors import RoISError
from openrois.federation.command_routes import CommandRoutes
from openrois.federation.destinations import OF_ENGINE, engine_named
from openrois.federation.federation import Federation
from openrois.federation.resumption import Resumption
from openrois.federation.routes import Routes, fitting
from openrois.federation.stop_routes import StopRoutes
from openrois.federation.sub_session import SubSession, UnwritableParams
from openrois.federation.sub_sessions import PRINCIPAL
from openrois.federation.system_routes import SystemRoutes
from openrois.interfaces import directory_methods
from openrois.interfaces.query import FAILING, STATUS_QUERY
from openrois.interfaces.selection import COMPONENT_PROPERTIES, observed_component, queried_component
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Handler, Reply
from openrois.scope.scoped_tree import ScopedTree
from openrois.scope.views import ViewChange
from openrois.session.change_notice import ChangeNotice
from openrois.session.session import ApplicationSession
from openrois.session.stream_parameters import lost_streams
from openrois.transport.stream import StreamClosed
from openrois.types.codes import CompletedStatus, ErrorType, ReturnCode
from openrois.types.directory import DirectoryChangedNotification
from openrois.types.leases import LeaseState
from openrois.types.messages import QueryParams, ResultsResult, ReturnResult, SubscribeParams
from openrois.types.methods import METHODS

__all__ = ["Router", "without_directory"]

_log = logging.getLogger(__name__)

_RESULTS: Final = {method.name: method.result for method in METHODS}
_OF_DIRECTORY: Final = frozenset({"rois.system.profile_changed", DirectoryChangedNotification.method})

_UNREACHED: Final = "is not reached any more; what had begun may go on"

_LOOKING: Final = frozenset({"rois.command.get_parameter", "rois.command.release"})
_BINDING: Final = frozenset({"rois.command.bind", "rois.command.release"})


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
        change_notice: notifies of changes of the directory.
    """

    def __init__(
        self,
        federation: Federation,
        app: ApplicationSession,
        local: BoundMethods,
        notify: Callable[..., None],
        address: str,
    ) -> None:
        self._local = local
        self._routes = Routes(federation, app, local, notify, address, self._handle_loss)
        self.change_notice = ChangeNotice(notify, lambda engine_id: self.engine.tree.has_engine(engine_id))
        self._resumption = Resumption(self._routes)
        self._stop_listening = self.engine.on_change(self._tree_changed)

    @property
    def engine(self) -> ScopedTree:
        """All engines of the cluster that the application sees."""
        return self._routes.engine

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether the application sees an engine that has the streaming methods."""
        return self.engine.tree.has_engine(engine_id) and self._routes.federation.directory.has_streams(engine_id)

    @property
    def principal(self) -> Principal:
        """The principal of the application; another one takes its place here and at all gateways."""
        return self._routes.app.principal

    @principal.setter
    def principal(self, principal: Principal) -> None:
        self._routes.app.principal = principal
        self.engine.principal = principal
        self._routes.subs.send_notification(PRINCIPAL, self._routes.assertion().hello())

    def _tree_changed(self, change: ViewChange) -> None:
        if change.visible:
            self.change_notice.changed(change.engine_ids)
            self._resumption.find_again(change.engine_ids)

    async def close(self, *, lost: bool) -> None:
        """End the sessions at other gateways.

        Args:
            lost: the connection of the application was lost.
        """
        self._stop_listening()
        self.change_notice.close()
        self.engine.close()
        self._routes.federation.works.discard(self._routes.work)
        await self._routes.subs.close(lost=lost)
        await self._resumption.close(lost=lost)

    def methods(self) -> Mapping[str, Handler]:
        """Return the methods of the application, in the place of those of its session here."""
        routed = CommandRoutes(self._routes).methods()
        return _Methods(
            routed.before(
                SystemRoutes(self._routes, self.change_notice).methods(),
                StopRoutes(self._routes, self._routes.federation.other_way).methods(),
                self._resumption.methods(),
                BoundMethods((_METHODS, self)),
            ),
            directory_methods(self).before(self._local),
            self._answer,
        )

    async def _answer(self, name: str, handler: Handler, params: dict[str, Any]) -> Any:
        """Answer a failure in RoIS terms as an operation does.

        After the methods of extensions the sessions elsewhere speak these too.
        """
        try:
            said = await handler(params)
        except UnwritableParams:
            # The session here says what is wrong with params that do not fit.
            said = await self._local[name](params)
        except RoISError as error:
            _log.debug("%s: %s", name, error)
            return Reply(_RESULTS.get(name, ReturnResult)(return_code=error.return_code), reason=str(error))
        if _extends(name):
            await self._routes.extend()
        return said

    async def _lead(self, name: str, params: dict[str, Any]) -> Any:
        component_ref = params.get("component_ref")
        gateway_id = self._routes.gateway(engine_named(name, params), component_ref)
        refs = (component_ref,) if isinstance(component_ref, str) else ()
        if name not in _LOOKING:
            for each in refs:
                self._resumption.note_use(each)
        return await self._routes.ask_at(
            *(gateway_id, name, params),
            refs=refs,
            urgent=name == "rois.command.release",
            accepted=lambda result: self._note_held(name, component_ref, result),
        )

    def _note_held(self, name: str, component_ref: object, result: Mapping[str, Any]) -> None:
        """Note what the application holds by the answer to a request."""
        if result.get("return_code") != ReturnCode.OK.value or not isinstance(component_ref, str):
            return
        lease = result.get("lease")
        if name in _BINDING:
            self._routes.work.note_held(component_ref, is_held=name != "rois.command.release")
        elif isinstance(lease, dict):
            self._routes.work.note_held(component_ref, is_held=lease.get("state") == LeaseState.MINE.value)

    async def _query(self, params: dict[str, Any]) -> Any:
        asked = fitting(QueryParams, params)
        if asked is None:
            return await self._local["rois.query.query"](params)
        if asked.query_type == STATUS_QUERY:
            component_ref = parse_condition(asked.condition, COMPONENT_PROPERTIES).value_of("component_ref")
            if component_ref is not None and self._has_lost(component_ref):
                return ResultsResult(results=(FAILING,))
        self._routes.require_reachable(asked.condition)
        component_ref = queried_component(self.engine, asked.query_type, asked.condition)
        return await self._routes.ask_about(component_ref, "rois.query.query", params)

    def _has_lost(self, component_ref: str) -> bool:
        return component_ref in self._routes.federation.directory.lost and self.engine.sees(component_ref)

    async def _subscribe(self, params: dict[str, Any]) -> Any:
        asked = fitting(SubscribeParams, params)
        if asked is None:
            return await self._local["rois.event.subscribe"](params)
        self._routes.require_reachable(asked.condition)
        component_ref = observed_component(self.engine, asked.event_type, asked.condition)
        return await self._routes.ask_about(component_ref, "rois.event.subscribe", params)

    async def _connect_stream(self, params: dict[str, Any]) -> Any:
        name, component_ref = "rois.stream.connect_stream", params.get("component_ref")
        gateway_id = self._routes.gateway(engine_named(name, params), component_ref)
        if gateway_id is not None:
            self._routes.app.extended = True

        def note(result: Mapping[str, Any]) -> None:
            stream_id = result.get("stream_id")
            if isinstance(stream_id, str) and stream_id and gateway_id is not None:
                self._routes.work.note_stream(gateway_id, stream_id, str(component_ref))

        return await self._routes.ask_at(gateway_id, name, params, refs=(str(component_ref),), accepted=note)

    async def _decide(self, name: str, params: dict[str, Any]) -> Any:
        request_id = params.get("request_id")
        gateway_id = self._routes.work.gateway_of_request(request_id) if isinstance(request_id, str) else None
        return await self._routes.ask_at(gateway_id, name, params)

    def _handle_loss(self, sub: SubSession, closed: StreamClosed) -> None:
        app, lost = self._routes.app, self._routes.work.lose(sub.gateway_id)
        reason = f"gateway {sub.gateway_id}, which has the engine, was lost: {closed}"
        for notice in lost_streams(lost.streams, {}, app.host.wall_clock()):
            if app.extended:
                self._routes.notify(notice.method, notice.model_dump(mode="json"))
        for command_id in lost.commands:
            app.completed(command_id, CompletedStatus.ERROR, f"gateway {sub.gateway_id}, at which it ran, {_UNREACHED}")
        refs = [ref for ref in sub.refs if self.engine.sees(ref)]
        self._resumption.note_loss(refs)
        for fault in app.host.engine.mint.make_each(ErrorType.COMPONENT_NOT_RESPONDING, refs, reason):
            app.tell_fault(fault)


def _named(method: Callable[[Router, str, dict[str, Any]], Awaitable[Any]], name: str) -> SharedMethod:
    return lambda router, params: method(router, name, params)


_METHODS: Final[Mapping[str, SharedMethod]] = {
    **{name: _named(Router._lead, name) for name in OF_ENGINE},
    **{name: _named(Router._decide, name) for name in ("openrois.lease.grant", "openrois.lease.decline")},
    "rois.query.query": Router._query,
    "rois.event.subscribe": Router._subscribe,
    "rois.stream.connect_stream": Router._connect_stream,
}


class _Methods(Mapping[str, Handler]):
    """The methods of one application.

    Args:
        routed: those that may go to another gateway.
        others: those that are answered here; of one name the routed one counts.
        answer: calls one of the former, or one of an extension.
    """

    __slots__ = ("_answer", "_others", "_routed")

    def __init__(
        self,
        routed: BoundMethods,
        others: BoundMethods,
        answer: Callable[[str, Handler, dict[str, Any]], Awaitable[Any]],
    ) -> None:
        self._routed = routed
        self._others = others
        self._answer = answer

    def __getitem__(self, name: str) -> Handler:
        handler = self._routed.get(name)
        if handler is None:
            handler = self._others[name]
            if not _extends(name):
                return handler
        return partial(self._answer, name, handler)

    def __iter__(self) -> Iterator[str]:
        return iter(self._routed.before(self._others))

    def __len__(self) -> int:
        return len(self._routed.before(self._others))


def _extends(name: str) -> bool:
    """Tell whether a method is an extension's; an application that calls one gets its notifications."""
    return name.startswith(("signaling.", "rois.stream.", "openrois."))
