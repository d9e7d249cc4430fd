"""The sub-engine's half of the wire: an engine served to its parent over a connection."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any, Final

from openrois.contract import Client
from openrois.engine.engine import Engine, leads_to
from openrois.errors import Aborted, EngineUnreachable, RoISError
from openrois.interfaces import base_methods, directory_methods
from openrois.interfaces.overload_rules import queue_rules
from openrois.jsonrpc.heartbeat import ALIVE, WATCH
from openrois.jsonrpc.reply_order import ReplyFirst
from openrois.jsonrpc.session import Handler, InvalidParams, NotificationHandler, Reply, RpcSession, method
from openrois.jsonrpc.token_renewal import renew_token
from openrois.leases.lease_notifications import notify_holder
from openrois.observability.correlation import connection
from openrois.remote.attachment import ATTACHED, QUESTIONS_ALONE, Attachment
from openrois.remote.extension import CLIENT_GONE, EXTENSION_METHODS, MAY_BIND, VISITORS
from openrois.session.session import ApplicationSession, EngineHost
from openrois.session.stream_parameters import lost_streams
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.types.codes import ComponentFunction, StreamStatus
from openrois.types.directory import DIRECTORY
from openrois.types.leases import LEASES
from openrois.types.references import engine_of
from openrois.types.stops import STOPPED, Stopped, StoppedNotification
from openrois.types.streams import (
    EXTENSIONS,
    STREAM_METHODS,
    HelloParams,
    HelloResult,
    HolderNotification,
    StreamStatusNotification,
    subject_of,
)

__all__ = ["serve_engine"]

_log = logging.getLogger(__name__)

STREAM_GRACE: Final = 10.0
"""Seconds for which streams go on when the connection to the parent has ended."""

_CONNECT: Final = STREAM_METHODS["connect_stream"]
_DISCONNECT: Final = STREAM_METHODS["disconnect_stream"]
_ENDED: Final = StreamStatus.STREAMING_NOT_CONNECTED.value


UNASKED: Final = 10.0
"""Seconds after which a warning says that no request has come: a gateway asks an adapter for its profile at once."""


async def serve_engine(
    host: EngineHost,
    stream: MessageStream,
    credentials: Credentials = NO_CREDENTIALS,
    *,
    url: str = "its address",
    attached: Callable[[bool], None] = lambda _is_attached: None,
) -> StreamClosed:
    """Serve an engine to the parent at the other end until the connection ends; return why it did.

    The parent is trusted: it checks reservations, this side does not. The streams of the parent's applications go on
    for `STREAM_GRACE` seconds after the connection has ended, so that a short cut of the control link does not darken a
    picture; then they end, because no application can command them any more.

    Args:
        host: the engine.
        stream: the connection.
        credentials: what is shown when the token in use is about to end.
        url: where the parent was reached, for the log.
        attached: called with True when the parent has attached the engine, with False when that connection ends.
    """
    session = RpcSession(stream, rules=queue_rules())
    loop, attachment = asyncio.get_running_loop(), Attachment(attached)
    unasked = loop.call_later(UNASKED, _tell_unasked, session, url)
    ungreeted = loop.call_later(QUESTIONS_ALONE, lambda: attachment.assume(was_asked=bool(session.requests)))
    app = ApplicationSession(host, session.notify, trusted=True)
    served = _ServedExtension(host, session.notify, app, attachment)
    session.on_failure = host.crashed
    session.explain = app.explain
    session.methods = {**base_methods(app), **directory_methods(app), **served.methods()}
    session.notifications = {
        **served.notifications(),
        **renew_token(session, credentials, host.tasks),
        ALIVE: lambda _params: host.heartbeat.sign(),
        ATTACHED: lambda _params: attachment.confirm(),
    }
    try:
        with connection(f"gateway-{app.client_id[:8]}"):
            return await session.run()
    finally:
        unasked.cancel()
        ungreeted.cancel()
        attachment.connection_ended()
        # Before anything else, what moves stops.
        host.heartbeat.cut("the connection to the gateway has ended")
        _end_waiting(host, app)
        host.epoch_fence.forget_parent(app)
        # Then what is held is let go: an engine below that does not answer must not delay that.
        host.tasks.start(served.close())
        await app.close()


def _tell_unasked(session: RpcSession, url: str) -> None:
    if not session.requests:
        _log.warning("no gateway at %s sends this adapter any request: connect it to ws://HOST:PORT/adapter", url)


def _end_waiting(host: EngineHost, app: ApplicationSession) -> None:
    """End commands that wait for their turn: behind the lost connection no application could stop them then."""
    for component_ref, profile in host.engine.components.items():
        if profile.function is ComponentFunction.ACTUATION:
            for command in host.pending.of(component_ref):
                if command.owner is app and command.task is None:
                    command.abort("the connection to the gateway ended before its turn came")


class _ServedExtension:
    """The extension calls of the parent's applications, each with its `client_id`."""

    def __init__(
        self,
        host: EngineHost,
        notify: Callable[[str, Mapping[str, Any]], None],
        parent: ApplicationSession,
        attachment: Attachment,
    ) -> None:
        self._attachment = attachment
        self._host = host
        self._notify = notify
        self._parent = parent
        self._order = ReplyFirst()
        self._clients: dict[str, Client] = {}
        self._streams: dict[str, tuple[str, str]] = {}
        self._holders = _Holders(host.engine)
        self._tells_stops = self._hears_stop = False
        self._stop_telling = host.stops.changes.add(self._tell_stop)
        self._stop_listening = host.engine.on_change(self._tree_changed)

    def methods(self) -> dict[str, Handler]:
        """Return `openrois.hello` and the extension methods."""

        async def hello(params: HelloParams) -> HelloResult:
            self._parent.extended = True
            self._attachment.greet(params.extensions)
            if STOPPED in params.extensions:
                self._tells_stops = True
            if LEASES in params.extensions:
                self._host.heartbeat.attach(lambda wanted: self._notify(WATCH, {"wanted": wanted}))
            extensions: tuple[str, ...]
            if DIRECTORY in params.extensions:
                # Each entry of the directory says whether its engine has streams.
                self._parent.change_notice.name_engines()
                extensions, engines = (*EXTENSIONS, DIRECTORY, LEASES, MAY_BIND, STOPPED, VISITORS), tuple[str, ...]()
            else:
                engines = tuple(sorted(self._host.engine.extension.engines()))
                extensions = (*EXTENSIONS, LEASES, MAY_BIND, STOPPED, VISITORS) if engines else (LEASES, STOPPED)
            latch = self._host.stop_latch
            stopped = latch.of(self._host.engine.tree.engine_ids)
            return HelloResult(
                extensions=extensions,
                engines=engines,
                instance=self._host.instance,
                epoch=self._host.epoch_fence.greatest,
                stopped=tuple(
                    Stopped(engine_id=engine_id, by=by, stop_id=latch.stop_id(engine_id))
                    for engine_id, by in stopped.items()
                ),
            )

        return {"openrois.hello": method(HelloParams, hello), **{m: self._calling(m) for m in EXTENSION_METHODS}}

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers of the parent's notifications about its applications."""

        async def forget(client_id: str) -> None:
            client = self._forget_client(client_id)
            if client is not None:
                await self._host.engine.extension.forget_client(client)

        def holder(params: dict[str, Any]) -> None:
            client_id = str(params.pop("client_id", ""))
            notification = HolderNotification.read_newer(params)
            if notification.component_ref not in self._host.engine.components:
                return
            if not self._host.epoch_fence.note(self._parent, notification.component_ref, notification.epoch):
                _log.warning(
                    "a gateway reports a former holder of %s, which is ignored", notification.component_ref[:200]
                )
                return
            self._host.tasks.start(self._handle_holder(notification, client_id))

        def client_gone(params: dict[str, Any]) -> None:
            # In a task, as requests are: what the application asked just before has to be begun first.
            self._host.tasks.start(forget(str(params.get("client_id"))))

        def stopped(params: dict[str, Any]) -> None:
            self._hears_stop = True
            try:
                self._host.stops.handle_notice(StoppedNotification.read_newer(params))
            finally:
                self._hears_stop = False

        return {CLIENT_GONE: client_gone, HolderNotification.method: holder, STOPPED: stopped}

    async def _handle_holder(self, notification: HolderNotification, client_id: str) -> None:
        if client_id:
            client = self._clients.get(client_id)
            if client is None and notification.holds:
                client = self._clients[client_id] = Client(client_id, self._notifying(client_id))
            if client is not None:
                await self._holders.notify_engine(notification, client)

    def _calling(self, name: str) -> Handler:
        async def call(params: dict[str, Any]) -> Reply:
            client_id = params.pop("client_id", None)
            if not isinstance(client_id, str) or not client_id:
                raise InvalidParams([{"path": "client_id", "message": "the application's client_id is missing"}])
            replied = self._order.asked((client_id, engine_of(subject_of(params))))
            try:
                return Reply(await self._call(name, params, client_id), replied)
            except RoISError as error:
                return Reply({"return_code": error.return_code.value}, replied, str(error))
            except BaseException:
                replied()
                raise

        return call

    async def _call(self, name: str, params: dict[str, Any], client_id: str) -> dict[str, Any]:
        client = self._clients.get(client_id)
        if client is None:
            client = Client(client_id, self._notifying(client_id))
            if name == _CONNECT:
                self._clients[client_id] = client
        extension = self._host.engine.extension
        bus = self._host.engine.route(subject_of(params)) if name == _CONNECT else None
        result = await extension.call(name, params, client)
        if bus is not None and not leads_to(self._host.engine, subject_of(params), bus):
            raise EngineUnreachable("the connection to the engine ended while the stream was made")
        if name == _CONNECT and self._clients.get(client_id) is not client:
            # The application went while its stream was made: the engine has to end that one, too.
            await extension.forget_client(client)
            raise Aborted("the application is gone")
        self._note_stream(name, params, result, client_id)
        return result

    def _note_stream(self, name: str, params: Mapping[str, Any], result: Mapping[str, Any], client_id: str) -> None:
        if name == _CONNECT and result.get("stream_id"):
            self._streams[str(result["stream_id"])] = (client_id, subject_of(params))
        elif name == _DISCONNECT:
            self._streams.pop(subject_of(params), None)

    def _notifying(self, client_id: str) -> Callable[[str, Mapping[str, Any]], None]:
        def notify(name: str, params: Mapping[str, Any]) -> None:
            notification = {**params, "client_id": client_id}
            if name == StreamStatusNotification.method and params.get("status") == _ENDED:
                self._streams.pop(str(params.get("stream_id")), None)
            self._order.notify_after_replies(
                (client_id, engine_of(subject_of(params))), lambda: self._notify(name, notification)
            )

        return notify

    def _tree_changed(self) -> None:
        components = {stream_id: component_ref for stream_id, (_, component_ref) in self._streams.items()}
        for notice in lost_streams(components, self._host.engine.components, self._host.wall_clock()):
            client_id, _ = self._streams.pop(notice.stream_id)
            self._notify(notice.method, {**notice.model_dump(mode="json"), "client_id": client_id})

    def _tell_stop(self, notice: StoppedNotification) -> None:
        """Tell the parent of a STOP that it has not said itself, if it wants to know."""
        if self._tells_stops and not self._hears_stop:
            self._notify(notice.method, notice.model_dump(mode="json"))

    def _forget_client(self, client_id: str) -> Client | None:
        """Drop a client and return it, if it was known."""
        self._streams = {key: owned for key, owned in self._streams.items() if owned[0] != client_id}
        client = self._clients.pop(client_id, None)
        if client is not None:
            self._holders.forget_client(client)
        return client

    async def close(self) -> None:
        """End what applications of the parent hold, at once, and the streams of all of them after the grace."""
        self._stop_listening()
        self._stop_telling()
        await self._holders.clear()
        await self._host.sleep(STREAM_GRACE)
        clients, self._clients = tuple(self._clients.values()), {}
        self._streams.clear()
        for client in clients:
            await self._host.engine.extension.forget_client(client)


class _Holders:
    """The holders among the parent's applications, to be ended here when the connection is gone."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._held: dict[str, tuple[HolderNotification, Client]] = {}

    async def notify_engine(self, notification: HolderNotification, client: Client) -> None:
        """Note a holder, and notify the engine of the component."""
        if notification.holds:
            self._held[notification.component_ref] = notification, client
        elif self._held.get(notification.component_ref, (None, None))[1] is client:
            del self._held[notification.component_ref]
        await notify_holder(self._engine, notification, client)

    def forget_client(self, client: Client) -> None:
        """Drop what a client held that is gone; the engines learn of its end anyway."""
        self._held = {ref: held for ref, held in self._held.items() if held[1] is not client}

    async def clear(self) -> None:
        """End every lease."""
        held, self._held = self._held, {}
        for notification, client in held.values():
            await notify_holder(self._engine, notification.model_copy(update={"holds": False}), client)
