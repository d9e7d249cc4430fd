"""Adapters at the gateway: each connection is asked for its profile, checked, and becomes part of the tree."""

import asyncio
import logging
import secrets
from typing import Final

from openrois.auth.principal import LOCAL, Principal, quota_name
from openrois.contract import Directory
from openrois.errors import BadParameter, RoISError
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

_FAREWELLS: Final = frozenset({1000, 1001, 1005, 1008, 1012})
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
) -> StreamClosed:
    """Attach the engine at the other end for as long as the connection lasts; return why it ended.

    A profile that is unreadable or not acceptable closes the connection with 1008 and the reason. The same holds for
    a later one, after the adapter said `rois.system.profile_changed`; said many times at once it counts as few.

    Args:
        host: the gateway's engine.
        stream: the connection.
        answer_timeout: seconds that the adapter has for each answer.
        expiry: the principal of the connection, and for how long; without it the local one.
        renewal: how that is made longer.
        sign_ins: records that it came and left.
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
    proxy.accepts = lambda directory: _require_scope(expiry.principal, directory)
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
    attaching = host.tasks.start(_keep_attached(host, session, proxy, changed, expiry))
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
        attaching.cancel()
        heartbeat.stop()
        well = closed.code in _FAREWELLS
        gone = engine.detach(proxy, lost="" if well else f"the connection to its engine has ended: {closed}")
        proxy.lost("the connection to the engine has ended")
        host.leases.end_all(gone)


async def _keep_attached(
    host: EngineHost, session: RpcSession, proxy: RemoteProxy, changed: asyncio.Event, expiry: TokenExpiry
) -> None:
    try:
        await host.engine.attach(proxy, own=False)
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
            host.leases.end_all(await host.engine.refresh(proxy))
            await host.sleep(CHANGE_PAUSE)
    except BadParameter as error:
        await _refuse(host, session, expiry, str(error))
    except RoISError as error:
        await _refuse(host, session, expiry, f"no usable profile: {error}")


def _require_scope(principal: Principal, directory: Directory) -> None:
    """Raise `BadParameter` where an adapter offers what its token does not cover; the engine's name counts, too."""
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
