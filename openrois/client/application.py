"""State of an application at its gateway, carried over from connection to connection, and the routing of notices."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, Final
from weakref import WeakSet

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.client.bindings import Bindings
from openrois.client.commands import Commands
from openrois.client.control import control_notice
from openrois.client.engine_directory import EngineDirectory, Generations
from openrois.client.errors import ConnectionLost
from openrois.client.feed import Feed
from openrois.client.notices import ControlChanged, Fault, Notice, Notification, ProfileChanged
from openrois.client.reconnect import Reconnect
from openrois.client.restoring import Restorer
from openrois.client.resumption import Resumption
from openrois.client.rpc_call import ask, read_message
from openrois.client.subscriptions import Asker, Subscriptions
from openrois.jsonrpc.protocol import METHOD_NOT_FOUND
from openrois.jsonrpc.session import NotificationHandler, RpcError, RpcSession
from openrois.jsonrpc.token_renewal import renew_token
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.types.directory import DIRECTORY, DirectoryChangedNotification
from openrois.types.leases import LEASES, LeaseState
from openrois.types.messages import Completed, ErrorNotification, EventNotification, NoParams, ReturnResult
from openrois.types.reasons import ReasonNotification, sentence
from openrois.types.streams import EXTENSION_VERSION, EXTENSIONS, HelloParams, HelloResult

__all__ = ["Application"]


class Application:
    """Owner of a client's connection.

    Attributes:
        commands, bindings, subscriptions: what it has at the gateway.
        extensions: what the gateway speaks beyond RoIS.
        generations: count how often engines came, changed or went, as far as that can be known.
        directory: the engines that there are.
        notices, listeners: feeds of notices, and of notifications as they come.
        on_notice: called with each notice.
        notifications: handlers of the gateway's notifications.
    """

    def __init__(
        self,
        asker: Callable[[], Asker],
        reconnect: Reconnect,
        request_timeout: float,
        credentials: Credentials = NO_CREDENTIALS,
    ) -> None:
        self.commands = Commands()
        self.bindings = Bindings(self.handle_notice)
        self.subscriptions = Subscriptions(asker, self.handle_notice)
        self.extensions: frozenset[str] = frozenset()
        self.generations = Generations()
        self.directory = EngineDirectory(asker)
        self.notices: WeakSet[Feed[Any]] = WeakSet()
        self.listeners: WeakSet[Feed[Any]] = WeakSet()
        self.on_notice: Listeners[Notice] = Listeners()
        self.notifications: Mapping[str, NotificationHandler] = _EveryName(self._handle_notification)
        self._restorer = Restorer(self.bindings, self.subscriptions, reconnect, request_timeout)
        self._resumption = Resumption(self.commands, self.bindings, request_timeout)
        self._timeout = request_timeout
        self._session: RpcSession | None = None
        self._credentials = credentials
        self._expiring: Mapping[str, NotificationHandler] = {}

    async def greet_gateway(self, session: RpcSession) -> None:
        """Connect as an application and learn which extensions the gateway has."""
        self._all_may_have_changed()
        self._session = session
        await ask(session, "rois.system.connect", NoParams(), ReturnResult, timeout=self._timeout)
        self.extensions = await self._hello(session)
        await self._resumption.greet_gateway(session, extended=LEASES in self.extensions)

    async def _hello(self, session: RpcSession) -> frozenset[str]:
        params = HelloParams(version=EXTENSION_VERSION, extensions=(*EXTENSIONS, DIRECTORY))
        try:
            answer = await ask(session, "openrois.hello", params, HelloResult, timeout=self._timeout)
        except RpcError as error:
            if error.code == METHOD_NOT_FOUND:
                return frozenset()
            raise
        return frozenset(answer.extensions)

    async def restore_state(self, session: RpcSession) -> None:
        """Bind again what was bound, as far as that is possible."""
        await self.bindings.renew(session, self._timeout)

    async def run_background(self, session: RpcSession) -> None:
        """Keep bindings and subscriptions complete for as long as the connection lasts."""
        async with TaskScope() as tasks:
            self._expiring = renew_token(session, self._credentials, tasks)
            tasks.start(self._find_ends(session))
            try:
                await self._restorer.run(session)
            finally:
                self._expiring = {}

    async def _find_ends(self, session: RpcSession) -> None:
        with suppress(ConnectionLost, TimeoutError):
            await self._resumption.run_background(session)

    def end_connection(self, reason: str, *, lost: bool = False, again: bool = False) -> None:
        """Mark what the connection held as lost; the next one may still report how its commands end."""
        self._resumption.end_connection(reason, lost=lost, again=again)
        self.bindings.lost()
        self.subscriptions.lost()

    def handle_closed(self, error: Exception | None) -> None:
        """End every feed: there will be no connection any more."""
        self.subscriptions.end_feeds(error)
        for feed in (*self.notices, *self.listeners):
            feed.end_feed(error)

    def handle_notice(self, notice: Notice) -> None:
        """Put a notice into every feed of notices, and pass it on."""
        for feed in tuple(self.notices):
            feed.offer(notice)
        self.on_notice.notify_all(notice)

    def _handle_notification(self, method: str, params: dict[str, Any]) -> None:
        for feed in tuple(self.listeners):
            feed.offer(Notification(method, params))
        if method in self._expiring:
            self._expiring[method](params)
        match method:
            case ReasonNotification.method:
                self._handle_reason(read_message(ReasonNotification, params))
            case "rois.command.completed":
                self.commands.completed(read_message(Completed, params))
            case "rois.event.notify_event":
                self.subscriptions.deliver(read_message(EventNotification, params))
            case "rois.system.profile_changed":
                self._all_may_have_changed()
                self._restorer.profile_changed()
                self.handle_notice(ProfileChanged())
            case DirectoryChangedNotification.method:
                self._handle_changes(read_message(DirectoryChangedNotification, params))
            case "rois.system.notify_error":
                fault = read_message(ErrorNotification, params)
                self.handle_notice(Fault(fault.error_id, fault.error_type))
            case _:
                self._handle_lease(method, params)

    def _all_may_have_changed(self) -> None:
        self.generations.count_all()
        self.directory.reset()

    def _handle_changes(self, notice: DirectoryChangedNotification) -> None:
        self.directory.note_changes(notice)
        engine_ids = frozenset[str]() if notice.unnamed else frozenset((*notice.changed, *notice.gone))
        if engine_ids:
            self.generations.count(engine_ids)
        else:
            self.generations.count_all()
        self._restorer.profile_changed(engine_ids)
        self.handle_notice(ProfileChanged(engine_ids))

    def _handle_lease(self, method: str, params: dict[str, Any]) -> None:
        notice = control_notice(method, params)
        if notice is None:
            return
        if isinstance(notice, ControlChanged):
            self._note_holder(notice)
        self.handle_notice(notice)

    def _note_holder(self, now: ControlChanged) -> None:
        match now.state:
            case LeaseState.MINE:
                self.bindings.returned(now.component_ref)
            case LeaseState.FREE:
                self.bindings.not_returned(now.component_ref)
            case LeaseState.HELD if now.return_position:
                self.bindings.lent(now.component_ref, now.holder, now.return_in)
            case LeaseState.HELD:
                self.bindings.taken(now.component_ref, now.reason)

    def _handle_reason(self, notification: ReasonNotification) -> None:
        line = sentence(notification.reason)
        if notification.command_id is not None:
            self.commands.explain(notification.command_id, line)
        if self._session is not None:
            self._session.handle_reason(notification.request_id, line)


class _EveryName(Mapping[str, NotificationHandler]):
    """A table of handlers that has every name: notifications of unknown extensions go to the feeds, too."""

    _known: Final = (
        "rois.command.completed",
        "rois.event.notify_event",
        "rois.system.profile_changed",
        "rois.system.notify_error",
        DirectoryChangedNotification.method,
    )

    def __init__(self, take: Callable[[str, dict[str, Any]], None]) -> None:
        self._take = take

    def __getitem__(self, name: str) -> NotificationHandler:
        return partial(self._take, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._known)

    def __len__(self) -> int:
        return len(self._known)
