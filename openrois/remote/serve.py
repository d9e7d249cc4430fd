"""The sub-engine's half of the wire: an engine served to its parent over a connection."""

from collections.abc import Callable, Mapping
from typing import Any, Final

from openrois.application import ApplicationSession, EngineHost
from openrois.contract import Client
from openrois.errors import RoISError
from openrois.interfaces import base_methods
from openrois.jsonrpc.session import Handler, InvalidParams, NotificationHandler, RpcSession, method
from openrois.remote.extension import CLIENT_GONE, EXTENSION_METHODS
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.types.streams import HelloParams, HelloResult

__all__ = ["serve_engine"]

STREAM_GRACE: Final = 10.0


async def serve_engine(host: EngineHost, stream: MessageStream) -> StreamClosed:
    """Serve an engine to the parent at the other end until the connection ends; return why it did.

    The parent is trusted: it checks reservations, this side does not. The streams of the parent's applications go on
    for `STREAM_GRACE` seconds after the connection has ended, so that a short cut of the control link does not darken a
    picture; then they end, because nobody can command them any more.
    """
    session = RpcSession(stream)
    app = ApplicationSession(host, session.notify, trusted=True)
    served = _ServedExtension(host, session.notify)
    session.methods = {**base_methods(app), **served.methods()}
    session.notifications = served.notifications()
    try:
        return await session.run()
    finally:
        await app.close()
        host.tasks.start(served.close())


class _ServedExtension:
    """The extension calls of the parent's applications, each with its `client_id`."""

    def __init__(self, host: EngineHost, notify: Callable[[str, Mapping[str, Any]], None]) -> None:
        self._host = host
        self._notify = notify
        self._clients: dict[str, Client] = {}

    def methods(self) -> dict[str, Handler]:
        """Return `openrois.hello` and the extension methods."""

        async def hello(_params: HelloParams) -> HelloResult:
            return HelloResult()

        return {"openrois.hello": method(HelloParams, hello), **{m: self._calling(m) for m in EXTENSION_METHODS}}

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return what the parent tells about its applications."""

        def client_gone(params: dict[str, Any]) -> None:
            client_id = str(params.get("client_id"))
            if self._clients.pop(client_id, None) is not None:
                self._host.tasks.start(self._host.engine.extension.forget(client_id))

        return {CLIENT_GONE: client_gone}

    def _calling(self, name: str) -> Handler:
        async def call(params: dict[str, Any]) -> dict[str, Any]:
            client_id = params.pop("client_id", None)
            if not isinstance(client_id, str) or not client_id:
                raise InvalidParams([{"path": "client_id", "message": "the application's client_id is missing"}])
            client = self._clients.setdefault(client_id, Client(client_id, self._notifying(client_id)))
            try:
                return await self._host.engine.extension.call(name, params, client)
            except RoISError as error:
                return {"return_code": error.return_code.value}

        return call

    def _notifying(self, client_id: str) -> Callable[[str, Mapping[str, Any]], None]:
        def notify(name: str, params: Mapping[str, Any]) -> None:
            self._notify(name, {**params, "client_id": client_id})

        return notify

    async def close(self) -> None:
        """End the streams of every application of the parent, after the grace."""
        await self._host.sleep(STREAM_GRACE)
        clients, self._clients = self._clients, {}
        for client_id in clients:
            await self._host.engine.extension.forget(client_id)
