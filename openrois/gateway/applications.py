"""Applications at the gateway: each connection's session, its methods, and its share of signaling."""

import asyncio
import logging
import time
from collections import ChainMap
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final, cast

from openrois_signaling.messages import Answer, Bye, Candidate, CaptureClocks, IceServer, Offer, Restart
from openrois_signaling.methods import IceServers, TooLong, signaling_methods
from openrois_signaling.methods import InvalidParams as InvalidSignaling
from openrois_signaling.relay import PEERS_PER_OWNER, Refused, Relay, Upward
from pydantic import Field, ValidationError

from openrois.aio.rate import RateLimit
from openrois.auth.principal import LOCAL
from openrois.contract import Client
from openrois.errors import BadParameter, RoISError
from openrois.federation.assertion import Assertion
from openrois.federation.federation import Federation
from openrois.federation.lines import Lines, SessionLine
from openrois.federation.resumption import KEEP, REPORT
from openrois.federation.router import Router, without_directory
from openrois.federation.shared_quotas import TOLD
from openrois.federation.sub_sessions import PRINCIPAL
from openrois.gateway.draining import SERVICE_RESTART
from openrois.gateway.refusals import RefusalNotes
from openrois.gateway.renewal import Renewal, expiring
from openrois.gateway.sign_in import SignIns
from openrois.gateway.token_expiry import TokenExpiry
from openrois.interfaces import base_methods, directory_methods, lease_methods, stream_methods
from openrois.interfaces.enforcement import enforced
from openrois.interfaces.lease import held_leases, tell_missed
from openrois.interfaces.operation import operation, reply_first
from openrois.interfaces.overload_rules import queue_rules
from openrois.jsonrpc.method_tables import BoundMethods, SharedMethod
from openrois.jsonrpc.session import Handler, InvalidParams, Reply, RpcSession
from openrois.observability.correlation import connection
from openrois.observability.logs import Tally
from openrois.scope.views import ViewChange
from openrois.session.session import ApplicationSession, EngineHost
from openrois.transport.stream import POLICY_VIOLATION, MessageStream, StreamClosed
from openrois.types.leases import MAX_RESUMED, ResumeResult
from openrois.types.model import Model
from openrois.types.references import engine_of

__all__ = ["RESUMED", "SUB_SESSION", "serve_application", "serve_sub_session"]

_log = logging.getLogger(__name__)

_WITHOUT_HANDSHAKE: Final = 1006
"""The code of a connection that broke."""

_LOST: Final = frozenset({_WITHOUT_HANDSHAKE, 1011, 4000})
"""Close codes of a connection that was lost: it broke, or the application found the gateway silent.

Of these a page, and what is made of the SDK for C#, can only send 4000.
"""

SUB_SESSION: Final = "sub_session"
"""The kind, for figures, of a session whose application is connected to another gateway."""

_NO_METHODS: Final[Mapping[str, Handler]] = {}

RESUMED: Final = 4409
"""The close code of a connection whose session another one has resumed."""

_TO_APPLICATION: Final = {message.method: message for message in (Offer, Candidate, CaptureClocks, Bye)}


MAX_ENDING: Final = 2 * PEERS_PER_OWNER
"""Peer connections of one application that engines are asked to end at a time; more are left to end by themselves."""

REQUESTS_PER_SECOND: Final = 5000
"""Requests of one application in the long run; half of what a gateway can do. What is urgent does not count."""

REQUESTS_AT_ONCE: Final = 10_000
"""Requests of one application in a burst."""


async def serve_application(
    host: EngineHost,
    stream: MessageStream,
    expiry: TokenExpiry | None = None,
    renewal: Renewal | None = None,
    sign_ins: SignIns | None = None,
    federation: Federation | None = None,
) -> StreamClosed:
    """Serve one application until its connection ends; return why it did.

    Args:
        host: the gateway's engine.
        stream: the connection.
        expiry: the principal of the connection, and for how long; without it the local one.
        renewal: how that is made longer.
        sign_ins: records that it came and left.
        federation: the other gateways, whose engines the application has too; None for those of this one alone.
    """
    served = _Served(host, stream, expiry or TokenExpiry(LOCAL), federation)
    more: Mapping[str, Handler] = _NO_METHODS
    if renewal is not None:
        more = renewal.method(served.expiry, lambda principal: principal.is_application, served.notes.note_token)
    methods = ChainMap(dict(more), cast(Any, served.methods))
    return await served.run(methods, sign_ins or SignIns(host.audit), "application")


async def serve_sub_session(
    host: EngineHost,
    stream: MessageStream,
    expiry: TokenExpiry,
    sign_ins: SignIns,
    lines: Lines,
    assertion: Assertion,
    is_cut: Callable[[], bool],
    hear_quotas: Callable[[Mapping[str, Any]], None],
) -> StreamClosed:
    """Serve one application that is connected to another gateway; return why that ended.

    Args:
        host: this gateway's engine: of others this application learns there.
        stream: to the other gateway.
        expiry: the principal that it asserts, and for how long.
        sign_ins: records that it came and left.
        lines: the sessions here that can be resumed.
        assertion: of the other gateway.
        is_cut: tells whether the stream was lost, so that the other gateway may have told the application so.
        hear_quotas: takes what the other gateway tells of subjects.
    """
    served = _Served(host, stream, expiry, None, assertion.client_id)
    app = served.app
    app.is_cut = is_cut
    app.is_relayed = True

    def replace(params: Mapping[str, Any]) -> None:
        try:
            principal = Assertion.parse(params).principal
        except BadParameter as error:
            # It may be less than before, as another version says it: what was asserted before holds no more.
            served.session.end_session(POLICY_VIOLATION, str(error))
            return
        if principal.subject == expiry.principal.subject and not expiry.is_over:
            expiry.replace(principal)

    def keep(params: Mapping[str, Any]) -> None:
        said = Assertion.parse(params)
        try:
            lines.adopt(app, SessionLine(said.line, said.generation))
        except RoISError as error:
            served.session.end_session(RESUMED, str(error))

    async def report(params: ResumeReportParams) -> Reply:
        known = app.commands
        result = ResumeResult(
            leases=held_leases(app), forgotten=tuple(each for each in params.command_ids if each not in known)
        )
        return Reply(result, lambda: tell_missed(app, params.command_ids))

    if assertion.line:
        try:
            lines.adopt(app, SessionLine(assertion.line, assertion.generation))
        except RoISError as error:
            await app.close()
            await stream.close(RESUMED, str(error))
            return StreamClosed(RESUMED, str(error))
    served.session.notifications = {PRINCIPAL: replace, KEEP: keep, TOLD: hear_quotas}
    reporting = {REPORT: operation(ResumeReportParams, ResumeResult, report)}
    return await served.run(served.methods, sign_ins, SUB_SESSION, reporting)


class ResumeReportParams(Model):
    """Params of `openrois.cluster.report`; `command_ids` are the commands whose end is not known."""

    command_ids: tuple[str, ...] = Field(default=(), max_length=MAX_RESUMED, strict=False)


class _Served:
    """One connection of an application: its session, and the methods that it has."""

    def __init__(
        self,
        host: EngineHost,
        stream: MessageStream,
        expiry: TokenExpiry,
        federation: Federation | None,
        client_id: str = "",
    ) -> None:
        rate = RateLimit(REQUESTS_AT_ONCE, REQUESTS_PER_SECOND, time.monotonic)
        self.expiry = expiry
        self.session = session = RpcSession(
            stream, rules=queue_rules(rate), latencies=host.connection_stats.latencies, on_failure=host.crashed
        )
        self._host = host
        self._stream = stream
        self._signaling = _Signaling(host)
        self.app = app = ApplicationSession(
            host,
            session.notify if federation is None else without_directory(session.notify),
            passes=self._signaling.passes,
            left=self._signaling.forget_peers,
            principal=expiry.principal,
            client_id=client_id,
        )
        self._signaling.app = app
        session.explain = app.explain
        self.notes = RefusalNotes(app)
        session.on_refusal = self.notes.note
        session.outbox.gap = app.gap
        own = base_methods(app).before(
            directory_methods(app), stream_methods(app), lease_methods(app), BoundMethods((_SIGNALING, self._signaling))
        )
        self._router = None
        if federation is not None:
            self._router = Router(federation, app, own, session.notify, expiry.address)
        self.methods: Mapping[str, Handler] = own if self._router is None else self._router.methods()
        expiry.on_principal = partial(setattr, self._router or app, "principal")
        expiry.on_expiring = expiring(session.notify, lambda: app.extended)
        app.end_connection = partial(session.end_session, RESUMED, "another connection has resumed this session")

    async def run(
        self, methods: Mapping[str, Handler], sign_ins: SignIns, kind: str, more: Mapping[str, Handler] = _NO_METHODS
    ) -> StreamClosed:
        """Serve until the connection ends; return why it did.

        Args:
            methods: those of the application, as far as its roles allow them.
            sign_ins: records that it came and left.
            kind: of the connection, for figures.
            more: methods of the gateway behind which the application is.
        """
        host, app, session, expiry = self._host, self.app, self.session, self.expiry
        session.methods = ChainMap(dict(more), cast(Any, enforced(app, methods)))
        stop_listening = app.engine.on_change(self._signaling.tree_changed)
        closed = StreamClosed(_WITHOUT_HANDSHAKE)
        lost = False
        try:
            with (
                connection(app.client_id[:8]),
                sign_ins.visit(expiry.principal, "/" if kind == "application" else "/cluster", expiry.address) as visit,
                host.connection_stats.counted(kind, session, app.events.count),
                host.quotas.serving(app),
                host.unread.account(app.quota_name, session.cut_unread) as unread,
            ):
                session.outbox.account = unread
                closed = await session.run()
                visit.ended = str(closed)
            # Of a cluster that restarts one gateway the application goes on at another one.
            is_sent_away = self._router is not None and closed.code == SERVICE_RESTART
            lost = closed.code in _LOST or is_sent_away
            return closed
        finally:
            stop_listening()
            async with asyncio.TaskGroup() as ending:
                if closed.code == RESUMED:
                    # It may be half open, which takes a while to notice.
                    ending.create_task(self._stream.close(closed.code, closed.reason))
                if self._router is not None:
                    ending.create_task(self._router.close(lost=lost))
                await app.close(lost=lost)


class _Signaling:
    """The relay of one application: its own peer connections are all it can name."""

    app: ApplicationSession

    def __init__(self, host: EngineHost) -> None:
        self._host = host
        self._relay: Relay[str, str] = Relay(self._forward, time.monotonic)
        self._peers: set[str] = set()
        self._malformed = Tally(_log, "malformed messages of signaling from an engine")
        self._ending = 0
        self._unended = Tally(_log, "peer connections that an application cannot have, too many to be ended")

    def passes(self, method: str, params: Mapping[str, Any]) -> bool:
        """Note which peers an engine opens and ends; a peer that the application cannot have is ended at once."""
        if method not in _TO_APPLICATION:
            return True
        try:
            peer_id = _TO_APPLICATION[method].model_validate(params).peer_id
        except ValidationError:
            self._malformed.note(method)
            return False
        if method == Offer.method:
            if not self._relay.register(peer_id, self.app.client_id, engine_of(peer_id)):
                self._end_peer(peer_id, f"the application has {PEERS_PER_OWNER} peer connections already")
                return False
            self._peers.add(peer_id)
        if method == Bye.method:
            self._forget_peer(peer_id)
        return True

    def _forget_peer(self, peer_id: str) -> None:
        self._peers.discard(peer_id)
        self._relay.forget_peer(peer_id, engine_of(peer_id))

    def _end_peer(self, peer_id: str, reason: str) -> None:
        """Make the engine end a peer, so that neither side waits in vain; the engine notifies the application."""
        if self._ending >= MAX_ENDING:
            # An engine offers without an end, and may not even answer.
            self._unended.note(engine_of(peer_id))
            return
        self._ending += 1
        self._host.tasks.start(self._say_bye(Bye(peer_id=peer_id, reason=reason), self.app.client))

    async def _say_bye(self, bye: Bye, client: Client) -> None:
        try:
            await self._host.engine.extension.call(bye.method, bye.wire(), client)
        except RoISError as error:
            _log.info("the engine does not end a peer connection that its application cannot have: %s", error)
        finally:
            self._ending -= 1

    def forget_peers(self) -> None:
        """Drop every peer: the application has left."""
        for peer_id in tuple(self._peers):
            self._forget_peer(peer_id)

    def tree_changed(self, _change: ViewChange) -> None:
        """Drop the peers of engines that are out of scope now; one that is still there ends them."""
        for peer_id in tuple(self._peers):
            if not self.app.engine.tree.has_engine(engine_of(peer_id)):
                self._forget_peer(peer_id)
                if self._host.engine.tree.has_engine(engine_of(peer_id)):
                    self._end_peer(peer_id, "the application may not have it any more")

    async def answer_request(self, name: str, params: dict[str, Any]) -> Reply:
        """Answer a method of `signaling.*`; an application that calls one gets the extensions' notifications."""
        self.app.extended = True
        # Made for each message: kept, it would take as much memory as it has methods in every session.
        methods = signaling_methods(self._relay, self.app.client_id, self._ice_servers)
        try:
            return Reply(await methods[name](params))
        except InvalidSignaling as error:
            raise InvalidParams(error.errors) from None
        except Refused as refusal:
            if name == Answer.method and isinstance(refusal, TooLong) and params.get("peer_id") in self._peers:
                self._end_peer(params["peer_id"], f"the answer cannot be passed on: {refusal}")
            return Reply({"return_code": refusal.return_code}, reason=str(refusal))

    def _ice_servers(self) -> IceServers:
        servers = self._host.ice_servers(self.app.client_id)
        return IceServers(tuple(IceServer.model_validate(server) for server in servers), self._host.ice_ttl)

    async def _forward(self, engine_id: str, message: Upward) -> None:
        params = message.wire()
        if isinstance(message, Restart) and (ice_servers := self._host.ice_servers(engine_id)):
            # What the engine was given when the stream was connected may have expired.
            params["ice_servers"] = list(ice_servers)
        try:
            result = await self._host.engine.extension.call(message.method, params, self.app.client)
        except RoISError as error:
            raise Refused(error.return_code.value, str(error)) from error
        code = result.get("return_code", "ERROR")
        if code != "OK":
            raise Refused(str(code), "")


def _signaling(name: str) -> SharedMethod:
    async def answer(signaling: _Signaling, params: dict[str, Any]) -> Reply:
        return await signaling.answer_request(name, params)

    return reply_first(answer)


_SIGNALING: Final = {
    name: _signaling(name) for name in (Answer.method, Candidate.method, Restart.method, "signaling.ice_servers")
}
