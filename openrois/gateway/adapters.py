"""Adapters at the gateway: each connection is asked for its profile, checked, and becomes part of the tree."""

import asyncio
import logging
import secrets
from typing import Final

from openrois.auth.principal import LOCAL, Principal, quota_name
from openrois.contract import Directory
from openrois.errors import BadParameter, RoISError
from openrois.gateway.claims import AdapterClaims, GatewayClaims, NotOwned
from openrois.gateway.draining import SERVICE_RESTART
from openrois.gateway.heartbeat import Heartbeat
from openrois.gateway.renewal import REFRESH, Renewal, expiring
from openrois.gateway.sign_in import SignIns
from openrois.gateway.token_expiry import TokenExpiry
from openrois.jsonrpc.session import CALL_TIMEOUT, RpcSession
from openrois.observability.correlation import connection
from openrois.remote.attachment import ATTACHED
from openrois.remote.proxy import RemoteProxy
from openrois.session.session import EngineHost
from openrois.transport.stream import POLICY_VIOLATION, MessageStream, StreamClosed
from openrois.types.references import engine_of

__all__ = ["serve_adapter"]

_log = logging.getLogger(__name__)

TRY_AGAIN_LATER: Final = 1013
"""The close code of a gateway that cannot serve now (IANA registry)."""

_FAREWELLS: Final = frozenset({1000, 1001, 1005, 1008, 1012, TRY_AGAIN_LATER})
"""Close codes after which an adapter is not missed: it disconnected, was refused, or the gateway itself stops."""

CHANGE_PAUSE: Final = 0.1
"""Seconds between two reads of one adapter's profile: every application is notified of each, and reads it again."""


async def serve_adapter(
    host: EngineHost,
    stream: MessageStream,
    answer_timeout: float = CALL_TIMEOUT,
    *,
    expiry: TokenExpiry | None = None,
    renewal: Renewal | None = None,
    sign_ins: SignIns | None = None,
    ownership: GatewayClaims | None = None,
) -> StreamClosed:
    """Attach the engine at the other end for as long as the connection lasts; return why it ended.

    A profile that is unreadable or not acceptable closes the connection with 1008 and the reason. The same holds for
    a later one, after the adapter said `rois.system.profile_changed`; said many times at once it counts as few. Engines
    that this gateway cannot own now close it with 1013 and `retry_after=<seconds>`, those that another gateway has
    claimed with 1012.

    Args:
        host: the gateway's engine.
        stream: the connection.
        answer_timeout: seconds that the adapter has for each answer.
        expiry: the principal of the connection, and for how long; without it the local one.
        renewal: how that is made longer.
        sign_ins: records that it came and left.
        ownership: claims the engines, where several gateways share them.
    """
    expiry = expiry or TokenExpiry(LOCAL)
    sign_ins = sign_ins or SignIns(host.audit)
    session = RpcSession(
        stream,
        call_timeout=answer_timeout,
        on_failure=host.crashed,
        call_latencies=host.connection_stats.call_latencies,
    )
    changed = asyncio.Event()
    proxy = RemoteProxy(session, changed.set, host.tasks)

    def detach(lost: str) -> None:
        attaching.cancel()
        offer = engine.tree.offer_of(proxy)
        gone = engine.detach(proxy, lost=lost)
        proxy.lost("the connection to the engine has ended")
        host.leases.end_all(gone)
        engine_ids = () if offer is None else offer.profile.engine_ids()
        host.stops.detach(engine_ids, proxy.identity.instance)
        for engine_id in engine_ids:
            host.epochs.detach(engine_id)

    def evict(reason: str) -> None:
        detach("")
        host.tasks.start(session.close(SERVICE_RESTART, reason))

    claims = None if ownership is None else ownership.adapter(proxy, evict)

    async def admit(directory: Directory) -> None:
        _require_scope(expiry.principal, directory)
        if claims is not None:
            await claims.admit(directory)

    proxy.admit = admit
    proxy.on_stopped = host.stops.handle_report
    heartbeat = Heartbeat(session, host.tasks)
    session.notifications = {**proxy.notifications(), **heartbeat.notifications()}
    expiry.on_principal = lambda _principal: None if expiry.is_over else changed.set()
    expiry.on_expiring = expiring(session.notify, lambda: proxy.speaks_extensions)
    if renewal is not None:
        session.methods = renewal.method(
            expiry,
            lambda principal: principal.is_adapter,
            lambda reason: host.audit.refused(expiry.principal, REFRESH, "", reason),
        )
    engine = host.engine
    attaching = host.tasks.start(_keep_attached(host, session, proxy, changed, expiry, claims))
    closed = StreamClosed(1006)
    try:
        name = f"adapter-{secrets.token_hex(4)}"
        with (
            connection(name),
            sign_ins.visit(expiry.principal, "/adapter", expiry.address) as visit,
            host.connection_stats.counted("adapter", session),
            host.unread.account(quota_name(expiry.principal, name), session.cut_unread) as unread,
        ):
            session.outbox.account = unread
            closed = await session.run()
            visit.ended = str(closed)
        return closed
    finally:
        if not attaching.done():
            _log.info("%s left: %s", ", ".join(proxy.engine_ids) or "an adapter that told no profile", closed)
        heartbeat.stop()
        is_lost = closed.code not in _FAREWELLS
        detach(f"the connection to its engine has ended: {closed}" if is_lost else "")
        if claims is not None:
            claims.end_claims(is_lost=is_lost)


async def _keep_attached(
    host: EngineHost,
    session: RpcSession,
    proxy: RemoteProxy,
    changed: asyncio.Event,
    expiry: TokenExpiry,
    claims: AdapterClaims | None,
) -> None:
    try:
        await host.engine.attach(proxy, own=False)
        _note_identity(host, proxy)
        session.peer = ", ".join(proxy.engine_ids)
        _log.info("attached %s", session.peer)
        is_notified = False
        while True:
            # An adapter that has answered the hello late knows from it that `ATTACHED` follows.
            if proxy.speaks_extensions and not is_notified:
                session.notify(ATTACHED, {})
                is_notified = True
            await changed.wait()
            changed.clear()
            await _refresh(host, proxy, changed)
            if claims is not None:
                claims.settle()
            await host.sleep(CHANGE_PAUSE)
    except NotOwned as error:
        _log.warning("an adapter is asked to dial again: %s", error)
        host.connection_stats.turn_away("ownership")
        await session.close(TRY_AGAIN_LATER, f"retry_after={error.retry_after:.2f} {error}")
    except BadParameter as error:
        await _refuse(host, session, expiry, str(error))
    except RoISError as error:
        await _refuse(host, session, expiry, f"no usable profile: {error}")


async def _refresh(host: EngineHost, proxy: RemoteProxy, changed: asyncio.Event) -> None:
    before = frozenset(proxy.engine_ids)
    try:
        gone = await host.engine.refresh(proxy)
    except NotOwned as error:
        if error.is_refused:
            raise
        # What is owned already goes on while the store is away.
        _log.warning("the new profile of %s waits: %s", ", ".join(proxy.engine_ids), error)
        await host.sleep(error.retry_after)
        changed.set()
        return
    host.leases.end_all(gone)
    host.leases.end_moved(proxy.engine_ids)
    host.stops.detach(before.difference(proxy.engine_ids), proxy.identity.instance)
    _note_identity(host, proxy)


def _note_identity(host: EngineHost, proxy: RemoteProxy) -> None:
    """Note what an adapter says of itself, before an application can command anything behind it."""
    for engine_id in proxy.engine_ids:
        host.epochs.attach(engine_id, proxy.identity.epoch)
    host.stops.attach(proxy.engine_ids, proxy.identity.stopped, proxy.identity.instance)


def _require_scope(principal: Principal, directory: Directory) -> None:
    """Raise `BadParameter` where an adapter offers what its token does not cover; the engine's name counts, too."""
    if principal.sees_everything:
        return
    refs = directory.profile.component_refs()
    leading = {engine_of(ref) for ref in refs}
    empty = (f"{engine_id}/" for engine_id in directory.profile.engine_ids() if engine_id not in leading)
    for ref in (*refs, *empty):
        if not principal.sees(ref):
            raise BadParameter(f"{ref[:300]!r} is out of the scope of the adapter's token")


async def _refuse(host: EngineHost, session: RpcSession, expiry: TokenExpiry, reason: str) -> None:
    _log.warning("an adapter was refused: %s", reason)
    host.audit.refused(expiry.principal, "/adapter", "", reason)
    host.connection_stats.turn_away("profile")
    await session.close(POLICY_VIOLATION, reason)
