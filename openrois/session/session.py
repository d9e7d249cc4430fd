"""One application at one engine: what it has bound, subscribed, started and connected, and its notifications.

The same class stands on both sides of a hop. At a gateway the session is an application's and the rules of reservation
hold; at an adapter it is the gateway's, which is trusted: it has checked the application behind it already.
"""

import asyncio
import secrets
import time
from collections.abc import Awaitable, Callable, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Any, Final, cast

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import LOCAL, Principal, quota_name
from openrois.auth.ranks import Ranks
from openrois.auth.subject_quotas import SubjectQuotas
from openrois.commands.history import MAX_RUNNING, MAX_RUNNING_TEXT, CommandHistory
from openrois.commands.pending import PendingCommands
from openrois.commands.quota import MAX_UNFINISHED, MAX_UNFINISHED_TEXT, CommandQuota
from openrois.commands.stop_latch import StopLatch
from openrois.contract import Client, Fault
from openrois.engine.engine import Engine
from openrois.errors import OutOfResources
from openrois.journal.journal import Journal, NoJournal
from openrois.jsonrpc.connection_stats import ConnectionStats
from openrois.jsonrpc.heartbeat import Heartbeat
from openrois.jsonrpc.protocol import Peer, RequestId
from openrois.jsonrpc.reply_order import ReplyFirst
from openrois.jsonrpc.unread import UnreadBudget
from openrois.leases.epoch_fence import EpochFence
from openrois.leases.epochs import CountedEpochs, Epochs
from openrois.leases.keeper import LeaseKeeper
from openrois.leases.lease_notifications import Holder
from openrois.leases.model import Rules
from openrois.leases.stop_keeper import StopKeeper
from openrois.observability.audit import Audit
from openrois.scope.revocation import Entitlements, end_streams
from openrois.scope.scoped_engine import ScopedEngine
from openrois.scope.views import ViewChange, Views
from openrois.session.change_notice import ChangeNotice
from openrois.session.error_log import ErrorLog
from openrois.session.events import EventLog
from openrois.session.stream_parameters import StreamParameters, lost_streams
from openrois.session.stream_rights import StreamRights
from openrois.types.codes import CompletedStatus, ErrorType, StreamStatus
from openrois.types.messages import Completed, ErrorNotification
from openrois.types.reasons import ReasonNotification, sentence
from openrois.types.references import engine_of
from openrois.types.streams import (
    EventsDroppedNotification,
    StreamStatusNotification,
    subject_of,
)

__all__ = ["RESTARTS", "ApplicationSession", "EngineHost", "forget_stream"]

RESTARTS: Final = "the gateway is about to restart"

Notify = Callable[..., None]


@dataclass
class EngineHost:
    """An engine and what its sessions share.

    Attributes:
        engine: the engine that is spoken to.
        tasks: owns the commands; they go on when the application that started them is gone.
        leases: holders of components and their queues.
        views: what applications of each scope see of the engine.
        commands: what the commands take that are accepted and not finished.
        unread: what waits to be sent on all connections.
        quotas: what the applications of one subject may have together.
        sleep: waits for some seconds, between the commands of a sequence.
        wall_clock: epoch seconds.
        ice_servers: what an end of a stream may use, as the W3C's RTCIceServer objects; its argument is the user.
        ice_ttl: seconds for which that may be kept.
        audit: actions and refusals.
        connection_stats: the connections, and what they did.
        journal: accepted commands and how they ended, for applications that ask after a restart.
        pending: commands that can be ended from outside.
        lease_rules: how long leases last.
        epochs: the numbers of leases.
        draining: it is about to end, and begins nothing new.
        heartbeat: to the parent, for what moves.
        epoch_fence: which parent reported the latest holder.
        ranks: of the principals of its applications.
        stop_latch: which engines persons have stopped for programs.
        stops: keeps programs from these.
        instance: a random text by which gateways know this engine's process again; no other engine may learn it.
    """

    engine: Engine
    tasks: TaskScope
    commands: CommandQuota = field(default_factory=CommandQuota)
    unread: UnreadBudget = field(default_factory=UnreadBudget)
    quotas: SubjectQuotas = field(default_factory=SubjectQuotas)
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
    wall_clock: Callable[[], float] = time.time
    ice_servers: Callable[[str], tuple[Mapping[str, Any], ...]] = lambda _user: ()
    ice_ttl: int = 3600
    audit: Audit = field(default_factory=Audit)
    connection_stats: ConnectionStats = field(default_factory=ConnectionStats)
    journal: Journal = field(default_factory=NoJournal)
    pending: PendingCommands = field(default_factory=PendingCommands)
    lease_rules: Rules = field(default_factory=Rules)
    epochs: Epochs = field(default_factory=CountedEpochs)
    draining: bool = False
    heartbeat: Heartbeat = field(default_factory=Heartbeat)
    epoch_fence: EpochFence = field(default_factory=EpochFence)
    ranks: Ranks = field(default_factory=Ranks)
    stop_latch: StopLatch = field(default_factory=StopLatch)
    instance: str = field(default_factory=lambda: secrets.token_hex(16), repr=False)
    leases: LeaseKeeper = field(init=False)
    stops: StopKeeper = field(init=False)
    views: Views = field(init=False)

    def __post_init__(self) -> None:
        self.views = Views(self.engine)
        self.leases = LeaseKeeper(
            self.engine,
            self.tasks,
            self.pending,
            rules=self.lease_rules,
            epochs=self.epochs,
            latch=self.stop_latch,
            ranks=self.ranks,
            acted=self.audit.acted,
            on_lost=_end_uplinks,
        )
        self.stops = StopKeeper(self.engine, self.leases, self.stop_latch, self.ranks)
        self.quotas.absent = lambda: self.leases.model.absent

    def require_staying(self) -> None:
        """Do nothing unless this is about to end.

        Raises:
            OutOfResources: it is, and begins nothing new.
        """
        if self.draining:
            raise OutOfResources(f"{RESTARTS}, and begins nothing new")

    def crashed(self, what: str) -> None:
        """Report an error inside the engine, which is no application's fault."""
        self.engine.report(ErrorType.ENGINE_INTERNAL_ERROR, f"{what} failed inside the engine")


def _end_uplinks(component_ref: str, holder: Holder) -> None:
    """End what a session sends into an engine when it operates nothing there any more."""
    session = cast(ApplicationSession, holder)
    held = session.host.leases.model.holding.held_by(session)
    lost = session.stream_rights.lost_with(component_ref, held)
    if lost:
        session.host.tasks.start(end_streams(session.host.engine, lost, session.client))


class ApplicationSession:
    """The state of one connection that speaks RoIS to the engine.

    Args:
        host: the engine and what is shared.
        notify: sends a notification to the application: method, params, `droppable=True` for events and
            `dispensable=True` for reasons.
        trusted: the other side is the parent engine; it needs no reservations.
        passes: sees every extension notification on its way to the application, and says whether it goes on.
        left: called when the application has left and its streams and peer connections are over.
        principal: of the application; another one takes its place when it shows a new token.
        client_id: the application's id; random unless another gateway has given it one.

    Attributes:
        engine: the part of the engine in the principal's scope: every name in a request is looked up there.
        end_connection: ends the connection at once; called when another session has gone on in this one's place.
        is_cut: tells whether the gateway that the application is connected to may have given up what it has here.
        is_relayed: whether the application is connected to another gateway.
        streams: the component_ref of each of its streams, by stream_id.
        change_notice: notifies of changes of the directory.
        stream_rights: by which right it has those of them that not every reader may have.
    """

    def __init__(
        self,
        host: EngineHost,
        notify: Notify,
        *,
        trusted: bool = False,
        passes: Callable[[str, Mapping[str, Any]], bool] = lambda _method, _params: True,
        left: Callable[[], None] = lambda: None,
        principal: Principal = LOCAL,
        client_id: str = "",
    ) -> None:
        self.host = host
        self.engine = ScopedEngine(host.engine, principal, host.views)
        self.trusted = trusted
        # A parent speaks for many applications: the share of one is kept where they are known apart.
        own = (MAX_UNFINISHED, MAX_UNFINISHED_TEXT) if trusted else (MAX_RUNNING, MAX_RUNNING_TEXT)
        self.commands = CommandHistory(time.monotonic, host.commands, *own)
        self.events = EventLog(host.engine, notify, wall_clock=host.wall_clock)
        self.errors = ErrorLog()
        self.bound: set[str] = set()
        self.connected = trusted
        self.client_id = client_id or secrets.token_hex(16)
        self.client = self._new_client()
        self.streams: dict[str, str] = {}
        self.stream_rights = StreamRights()
        self.stream_parameters = StreamParameters()
        self.connecting = 0
        self.order = ReplyFirst()
        self.extended = False
        self.leasing = False
        self.closed = False
        self.successor: ApplicationSession | None = None
        self.end_connection: Callable[[], None] = lambda: None
        self.is_cut: Callable[[], bool] = lambda: False
        self.is_relayed = False
        self.send_notification = self._notify = notify
        self._passes = passes
        self._left = left
        self.change_notice = ChangeNotice(notify, lambda engine_id: self.engine.tree.has_engine(engine_id))
        self._stop_listening = self.engine.on_change(self._tree_changed)
        self._stop_watching = host.engine.faults.add(self._handle_faults)

    def _new_client(self) -> Client:
        return Client(self.client_id, self._handle_extension_notification)

    @property
    def principal(self) -> Principal:
        """The principal of the application; another one in its place has another scope, and loses what is not in it."""
        return self.engine.principal

    @principal.setter
    def principal(self, principal: Principal) -> None:
        entitlements = Entitlements(principal)
        bound = entitlements.lost_bindings(self.bound)
        streams = {*entitlements.lost_streams(self.streams), *self.stream_rights.lost_without(principal)}
        # Narrow the scope first, so that the next notifications are filtered.
        self.engine.principal = principal
        self.bound.difference_update(bound)
        for component_ref in (*bound, *entitlements.lost_bindings(self.host.leases.model.lent_by(self))):
            self.give_back(component_ref)
        for component_ref in entitlements.lost_bindings(self.host.leases.model.waited_for(self)):
            self.host.leases.withdraw(component_ref, self)
        self.host.stops.handle_principal(self)
        if streams:
            self.host.tasks.start(end_streams(self.host.engine, streams, self.client))
        self.host.tasks.start(self.events.drop(entitlements.loses_subscription))

    def has_streams(self, engine_id: str) -> bool:
        """Tell whether an engine is in scope that has the streaming methods."""
        return self.engine.has_streams(engine_id)

    @property
    def sharer(self) -> str | None:
        """The name whose share commands count against; None for a parent, and where no token is needed."""
        return None if self.trusted or self.principal is LOCAL else self.principal.subject

    @property
    def quota_name(self) -> str:
        """The name that connections, streams and unread messages count against."""
        return quota_name(self.principal, self.client_id)

    def may_operate(self, component_ref: str) -> bool:
        """Tell whether this session may change what the component does."""
        if self.trusted:
            return self.host.epoch_fence.admits(self, component_ref)
        return self.host.leases.is_held(component_ref, self)

    def is_barred_from(self, component_ref: str) -> bool:
        """Tell whether another session holds the component now; a free one is open to commands that were accepted."""
        return not self.trusted and self.host.leases.is_held_by_another(component_ref, self.present())

    def present(self) -> "ApplicationSession":
        """Return the session that has gone on where this one ended; itself where there is none."""
        session = self
        while session.successor is not None:
            session = session.successor
        return session

    def give_back(self, component_ref: str) -> None:
        """End the session's reservation of a component, if it has one; its adapter is notified."""
        self.host.leases.release(component_ref, self)

    def succeed(self, former: "ApplicationSession") -> None:
        """Go on in the place of another session: its commands are notified here, what it had bound is bound here."""
        self.commands, former.successor = former.commands, self
        self.bound |= former.bound
        if not former.closed:
            former.end_connection()

    def explain(self, request_id: RequestId, reason: object) -> None:
        """Notify the application why the reply that follows is a refusal, if it knows that notification."""
        if request_id is not None:
            self._explain("request_id", request_id, reason)

    def _explain(self, name: str, subject: str | float, reason: object) -> None:
        line = sentence(reason) if self.extended else ""
        if line:
            self._notify(ReasonNotification.method, {name: subject, "reason": line}, dispensable=True)

    def completed(self, command_id: str, status: CompletedStatus, reason: object = "") -> None:
        """Notify the application how a command ended, and right before that why, where there is a reason."""
        session = self.present()
        session._explain("command_id", command_id, reason)
        session._notify(
            "rois.command.completed", Completed(command_id=command_id, status=status).model_dump(mode="json")
        )

    def gap(self, dropped: int) -> str | None:
        """Return the message that stands where events were dropped, if the application knows it."""
        if not self.extended:
            return None
        told = EventsDroppedNotification(count=dropped)
        return Peer.notification(told.method, told.model_dump(mode="json"))

    def _handle_faults(self, faults: tuple[Fault, ...]) -> None:
        used = self._used_components()
        for fault in faults:
            shown = self.engine.scoped_fault(fault) if self._is_concerned_by(fault, used) else None
            if shown is not None:
                self.tell_fault(shown)

    def tell_fault(self, fault: Fault) -> None:
        """Notify the application of a fault that it may see and that concerns it."""
        self.errors.note(fault)
        told = ErrorNotification(error_id=fault.error_id, error_type=fault.error_type).model_dump(mode="json")
        # Whatever was asked and failed is answered first.
        asyncio.get_running_loop().call_soon(lambda: self._notify("rois.system.notify_error", told, droppable=True))

    def _is_concerned_by(self, fault: Fault, used: AbstractSet[str]) -> bool:
        """Tell whether the application works with the component; the engine's own faults concern every one."""
        if self.trusted or not fault.component_ref:
            return self.connected
        return fault.component_ref in used

    def _used_components(self) -> AbstractSet[str]:
        """Return the components with which the application works."""
        return self.bound.union(self.events.sources(), self.commands.components(), self.streams.values())

    def _tree_changed(self, change: ViewChange) -> None:
        """Drop what is not in scope any more: it has left the tree, or the principal's scope."""
        if change.gone_refs:
            shown = self.engine.components
            for notice in lost_streams(self.streams, shown, self.host.wall_clock()):
                self._deliver(notice.method, notice.model_dump(mode="json"), notice)
            self.events.keep_only(shown)
            self.bound &= shown.keys()
            self.stream_parameters.keep_only(shown)
        if change.visible:
            self.change_notice.changed(change.engine_ids)

    def _handle_extension_notification(self, method: str, params: Mapping[str, Any]) -> None:
        # Read before it waits: a malformed one is the fault of its engine, not of the call that it waits for.
        is_status = method == StreamStatusNotification.method
        notice = StreamStatusNotification.read_newer(params) if is_status else None
        engine_id = engine_of(subject_of(params))

        def deliver() -> None:
            is_shown = notice is None or self.engine.sees(notice.component_ref)
            # What is not shown any more could not be ended in time.
            if is_shown and self.engine.tree.has_engine(engine_id):
                self._deliver(method, params, notice)

        self.order.notify_after_replies(engine_id, deliver)

    def _deliver(self, method: str, params: Mapping[str, Any], notice: StreamStatusNotification | None) -> None:
        if not self._passes(method, params):
            return
        if notice is not None:
            self.events.stream_status(notice)
            if notice.status is StreamStatus.STREAMING_NOT_CONNECTED:
                forget_stream(self, notice.stream_id)
        if self.extended:
            self._notify(method, params)

    async def leave(self, *, lost: bool = False) -> None:
        """Release reservations, subscriptions and streams. Commands run on.

        Args:
            lost: the connection was lost; what is reserved may be kept for a while.
        """
        self.connected = False
        if lost:
            self.host.leases.lose(self)
        else:
            self.host.leases.leave(self)
            self.bound.clear()
        for stream_id in tuple(self.streams):
            forget_stream(self, stream_id)
        self.stream_parameters.keep_only(())
        self.order.clear()
        self._left()
        former, self.client = self.client, self._new_client()
        await asyncio.gather(self.events.clear(), self.engine.extension.forget_client(former))

    async def close(self, *, lost: bool = False) -> None:
        """Leave for good; a session whose connection was lost may have a successor."""
        self.detach()
        await self.leave(lost=lost)

    def detach(self) -> None:
        """Have no connection any more, and be notified of nothing; what is held is another matter."""
        self.closed = True
        self._stop_listening()
        self._stop_watching()
        self.change_notice.close()
        self.events.close()
        self.engine.close()


def forget_stream(session: ApplicationSession, stream_id: str) -> None:
    """Forget a stream that has ended; the audit trail has the end of what visitors send and listeners receive."""
    component_ref = session.streams.pop(stream_id, "")
    right = session.stream_rights.forget_stream(stream_id)
    session.host.quotas.note_streams(session)
    if right.role is not None:
        session.host.audit.acted(session.principal, "stream.ended", component_ref, stream_id)
