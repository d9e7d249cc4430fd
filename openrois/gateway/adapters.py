"""Adapters at the gateway: each connection is asked for its profile, checked, and becomes part of the tree."""

import asyncio
import logging
import secrets
from typing import Final

from openrois.application import EngineHost
from openrois.correlation import connection
from openrois.errors import BadParameter, RoISError
from openrois.jsonrpc.session import CALL_TIMEOUT, RpcSession
from openrois.remote.proxy import RemoteProxy
from openrois.transport.stream import POLICY_VIOLATION, MessageStream, StreamClosed

__all__ = ["serve_adapter"]

_log = logging.getLogger(__name__)

_FAREWELLS: Final = frozenset({1000, 1001, 1005, 1008, 1012})
"""Close codes after which nobody is missed: the adapter took its leave, was refused, or the gateway itself stops."""

CHANGE_PAUSE: Final = 0.1
"""Seconds between two looks at one adapter's profile: every application hears of each, and asks again."""


async def serve_adapter(host: EngineHost, stream: MessageStream, answer_timeout: float = CALL_TIMEOUT) -> StreamClosed:
    """Attach the engine at the other end for as long as the connection lasts; return why it ended.

    A profile that cannot be had or is not acceptable closes the connection with 1008 and the reason. The same holds for
    a later one, after the adapter said `rois.system.profile_changed`; said many times at once it counts as few.

    Args:
        host: the gateway's engine.
        stream: the connection.
        answer_timeout: seconds that the adapter has for each answer.
    """
    session = RpcSession(
        stream, call_timeout=answer_timeout, on_failure=host.crashed, call_latencies=host.traffic.call_latencies
    )
    changed = asyncio.Event()
    proxy = RemoteProxy(session, changed.set, host.tasks)
    session.notifications = proxy.notifications()
    engine = host.engine
    attaching = host.tasks.start(_keep_attached(host, session, proxy, changed))
    closed = StreamClosed(1006)
    try:
        with connection(f"adapter-{secrets.token_hex(4)}"), host.traffic.counted("adapter", session):
            closed = await session.run()
        return closed
    finally:
        if not attaching.done():
            _log.info("%s left: %s", ", ".join(proxy.engine_ids) or "an adapter that told no profile", closed)
        attaching.cancel()
        well = closed.code in _FAREWELLS
        engine.detach(proxy, lost="" if well else f"the connection to its engine has ended: {closed}")
        proxy.lost("the connection to the engine has ended")
        host.leases.keep_only(set(engine.directory.component_profiles))


async def _keep_attached(host: EngineHost, session: RpcSession, proxy: RemoteProxy, changed: asyncio.Event) -> None:
    try:
        await host.engine.attach(proxy, own=False)
        session.peer = ", ".join(proxy.engine_ids)
        _log.info("attached %s", session.peer)
        while True:
            await changed.wait()
            changed.clear()
            await host.engine.refresh(proxy)
            host.leases.keep_only(set(host.engine.directory.component_profiles))
            await host.sleep(CHANGE_PAUSE)
    except BadParameter as error:
        await _refuse(host, session, str(error))
    except RoISError as error:
        await _refuse(host, session, f"no usable profile: {error}")


async def _refuse(host: EngineHost, session: RpcSession, reason: str) -> None:
    _log.warning("an adapter was refused: %s", reason)
    host.audit.refused(None, "/adapter", "", reason)
    host.traffic.turn_away("profile")
    await session.close(POLICY_VIOLATION, reason)
