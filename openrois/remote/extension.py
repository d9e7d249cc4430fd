"""The extension calls of many applications over one connection: each carries the `client_id` of its application."""

import logging
import secrets
from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Any, Final

from openrois.aio.lean_queue import LeanQueue
from openrois.aio.tasks import TaskScope
from openrois.contract import Client
from openrois.errors import ComponentFailed
from openrois.jsonrpc.outbox import Outbox
from openrois.jsonrpc.session import NotificationHandler
from openrois.observability.logs import Tally
from openrois.remote.lease_outbox import LeaseOutbox
from openrois.types.stops import StoppedNotification
from openrois.types.streams import STREAM_METHODS, HolderNotification

__all__ = ["CLIENT_GONE", "EXTENSION_METHODS", "EXTENSION_NOTIFICATIONS", "MAY_BIND", "VISITORS", "RemoteExtension"]

_log = logging.getLogger(__name__)

_CONNECT: Final = STREAM_METHODS["connect_stream"]

EXTENSION_METHODS: Final = (
    _CONNECT,
    "rois.stream.disconnect_stream",
    "rois.stream.suspend_stream",
    "rois.stream.resume_stream",
    "rois.stream.query_stream_status",
    "rois.stream.report_playout",
    "rois.stream.set_consent",
    "signaling.answer",
    "signaling.candidate",
    "signaling.restart",
    "signaling.bye",
)
"""Methods that a parent calls at its sub-engine for an application, with `client_id` beside the params."""

EXTENSION_NOTIFICATIONS: Final = (
    "rois.stream.notify_stream_status",
    "signaling.offer",
    "signaling.candidate",
    "signaling.capture_clocks",
    "signaling.bye",
)
"""Notifications of a sub-engine to its parent for an application, with `client_id` beside the params."""

CLIENT_GONE: Final = "openrois.client_gone"
"""Notification of a parent to its sub-engine: the application `client_id` is gone for good."""

MAY_BIND: Final = "openrois.may_bind"
"""Extension of an engine that takes `may_bind` beside the params of connect_stream; others do not get it."""

VISITORS: Final = "openrois.visitors"
"""Extension of an engine that takes `role` beside the params of connect_stream, and tells visitors apart."""

MAX_GONE: Final = 4096
"""Applications whose end waits to be notified; with one more it is notified without room."""


class RemoteExtension:
    """The extension of a remote engine; an `Extension`.

    A client has its own `client_id` on the other side, too, unless a former one with that id is still there.

    Args:
        ask: calls the other side and returns the result as it came; one that comes after the caller gave up goes to
            its third argument. Its fourth is called right before it asks, when there is room for that.
        post: asks the other side and drops the answer.
        notify: tells the other side.
        is_theirs: tells whether a reference or id belongs to an engine of the other side.
        outbox: what waits to be sent there.
        tasks: owns what waits for room in it.

    Attributes:
        takes_may_bind: whether the other side wants to know of an application that it may not bind.
        takes_role: whether the other side tells visitors apart, and keeps to their consent.
    """

    def __init__(
        self,
        ask: Callable[[str, Mapping[str, Any], Callable[[Any], None], Callable[[], None]], Awaitable[Any]],
        post: Callable[[str, Mapping[str, Any]], None],
        notify: Callable[[str, Mapping[str, Any]], None],
        is_theirs: Callable[[str], bool],
        outbox: Outbox,
        tasks: TaskScope,
    ) -> None:
        self._ask = ask
        self._post = post
        self._notify = notify
        self._is_theirs = is_theirs
        self._engines: frozenset[str] = frozenset()
        self._clients: dict[str, Client] = {}
        self._ids: dict[Client, str] = {}
        self._heard: set[str] = set()
        """The ids of clients that the other side knows."""
        self._gone = LeanQueue[str]()
        """Those of clients that are gone, where that waits for room to be notified."""
        self._outbox = outbox
        self._tasks = tasks
        self.takes_may_bind = False
        self.takes_role = False
        self._lease_outbox = LeaseOutbox(self._named, notify, outbox, tasks)
        self._foreign = Tally(_log, "notifications that name a reference or id of another engine")

    def engines(self) -> frozenset[str]:
        """Return the ids of the engines of the other side that have the extension."""
        return self._engines

    def limit_to(self, engines: Iterable[str]) -> None:
        """Set which engines of the other side have the extension."""
        self._engines = frozenset(engines)

    async def call(self, method: str, params: Mapping[str, Any], client: Client) -> dict[str, Any]:
        """Call a method for an application; from its first connect_stream on it gets the other side's notifications."""
        client_id = self._ids.get(client) or self._free_id(client)
        if method == _CONNECT:
            self._note(client, client_id)
            if not self.takes_may_bind:
                params = {name: value for name, value in params.items() if name != "may_bind"}

        def before() -> None:
            if client in self._ids:
                self._heard.add(client_id)
            elif method == _CONNECT:
                raise ComponentFailed("the application has left meanwhile")

        result = await self._ask(
            method, {**params, "client_id": client_id}, lambda late: self._end_late_stream(late, client_id), before
        )
        if not isinstance(result, dict):
            raise ComponentFailed(f"the engine's answer to {method} is not an object")
        return result

    async def set_holder(self, notification: HolderNotification, client: Client) -> None:
        """Notify the other side, now or when there is room."""
        self._lease_outbox.put_holder(notification, client)

    def put_stop(self, notification: StoppedNotification) -> None:
        """Notify the other side, now or when there is room, that a person has stopped or handed back an engine."""
        self._lease_outbox.put_stop(notification)

    def catch_up(self) -> None:
        """Notify which clients hold what and which are gone, where that waits and there is room by now."""
        self._lease_outbox.catch_up()
        while self._gone and self._outbox.is_roomy:
            self._tell_gone()

    async def _wait_to_tell(self) -> None:
        while self._gone and await self._outbox.room():
            self.catch_up()

    def _tell_gone(self) -> None:
        self._notify(CLIENT_GONE, {"client_id": self._gone.pop()})

    def _named(self, client: Client) -> str:
        """Return the id of a client on the other side, which is notified of its end from now on."""
        if client not in self._ids:
            self._note(client, self._free_id(client))
        self._heard.add(self._ids[client])
        return self._ids[client]

    def _note(self, client: Client, client_id: str) -> None:
        self._clients[client_id] = client
        self._ids[client] = client_id

    def _free_id(self, client: Client) -> str:
        return secrets.token_hex(16) if client.client_id in self._clients else client.client_id

    def _end_late_stream(self, result: Any, client_id: str) -> None:
        """End a stream that was connected too late for its caller: its id is known only here."""
        if isinstance(result, dict) and isinstance(stream_id := result.get("stream_id"), str) and stream_id:
            self._post("rois.stream.disconnect_stream", {"stream_id": stream_id, "client_id": client_id})

    async def forget_client(self, client: Client) -> None:
        """Notify the other side that an application is gone, if it knows it: now or when there is room."""
        client_id = self._ids.pop(client, None)
        self._lease_outbox.forget_client(client, client_id)
        if client_id is None:
            return
        del self._clients[client_id]
        if client_id not in self._heard:
            return
        self._heard.remove(client_id)
        self._gone.put(client_id)
        if len(self._gone) > MAX_GONE:
            # Another side that reads nothing for so long loses its connection, as by any other message too many.
            self._tell_gone()
        elif len(self._gone) == 1 and not self._outbox.is_roomy:
            self._tasks.start(self._wait_to_tell())
        self.catch_up()

    def notifications(self) -> dict[str, NotificationHandler]:
        """Return the handlers that pass a notification to its application."""
        return {name: self._passing(name) for name in EXTENSION_NOTIFICATIONS}

    def _passing(self, name: str) -> NotificationHandler:
        def take(params: dict[str, Any]) -> None:
            client = self._clients.get(str(params.pop("client_id", "")))
            if client is None:
                return
            named = (params[key] for key in ("component_ref", "stream_id", "peer_id") if key in params)
            if all(isinstance(reference, str) and self._is_theirs(reference) for reference in named):
                client.notify(name, params)
            else:
                self._foreign.note(name)

        return take

    def lost(self) -> None:
        """Drop the applications: the other side is gone."""
        self._clients.clear()
        self._ids.clear()
        self._heard.clear()
        self._gone.clear()
        self._lease_outbox.clear()
