"""The gateway's one port: the web demo, applications, adapters, schemas, health."""

import asyncio
import logging
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import (
    AbstractAsyncContextManager,
    AbstractContextManager,
    AsyncExitStack,
    ExitStack,
    asynccontextmanager,
    contextmanager,
    nullcontext,
)
from dataclasses import dataclass
from functools import partial
from typing import Final

from aiohttp import WSCloseCode, web

from openrois.aio.loop_lag import LoopLag
from openrois.aio.tasks import TaskScope
from openrois.auth.principal import LOCAL, quota_name
from openrois.auth.ranks import Ranks
from openrois.auth.subject_quotas import SubjectQuotas
from openrois.engine.engine import Engine
from openrois.errors import OutOfResources
from openrois.federation.federation import Federation
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.admission import guard
from openrois.gateway.applications import serve_application
from openrois.gateway.auth_setup import AuthSetup
from openrois.gateway.clustering import Clustering
from openrois.gateway.connection_limits import ConnectionLimits
from openrois.gateway.draining import RETRY_AFTER, Drain
from openrois.gateway.ice import IceServers
from openrois.gateway.metrics import Sources, figures
from openrois.gateway.page import page_response
from openrois.gateway.restart_barrier import RestartBarrier
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.socket import ADAPTER, APPLICATION, ServerSocket, SocketProfile
from openrois.gateway.stalling import Stalling
from openrois.gateway.token_expiry import TokenExpiry
from openrois.http_limits.header_timeout import OPTIONS, HeaderTimeouts
from openrois.http_limits.http_connection import HttpConnection
from openrois.http_limits.tcp_server import serving_tcp
from openrois.journal.journal import Journal, NoJournal
from openrois.journal.sqlite_journal import SqliteJournal
from openrois.jsonrpc.unread import UnreadBudget
from openrois.leases.epochs import CountedEpochs
from openrois.leases.model import Rules
from openrois.metrics.server import metrics_address, serving_metrics
from openrois.observability.audit import Audit
from openrois.observability.health import Readiness, healthz, readyz
from openrois.observability.log_lines import Redaction
from openrois.schema import openrpc
from openrois.session.session import RESTARTS, EngineHost
from openrois.transport.stream import MessageStream, StreamClosed

__all__ = ["Gateway", "run_gateway"]

_log = logging.getLogger(__name__)

_OPENRPC: Final = "openrpc.json"
_SHUTDOWN_TIMEOUT: Final = 1.0


async def _nothing() -> None:
    """Stand in where there is nothing to do."""


@dataclass(frozen=True, slots=True)
class Gateway:
    """A running gateway.

    Attributes:
        url: where a browser finds it.
        engine: the main HRI engine.
        metrics: where Prometheus finds figures; empty for nowhere.
        drain: admits no connection any more, waits for what runs, and closes every connection.
        reload: reads keys, certificates and revocations again.
        federation: the gateway among the others of its cluster; None where it is on its own.
    """

    url: str
    engine: Engine
    metrics: str = ""
    reload: Callable[[], None] = lambda: None
    drain: Callable[[], Awaitable[None]] = _nothing
    federation: Federation | None = None


@asynccontextmanager
async def run_gateway(
    settings: GatewaySettings, *, application: SocketProfile = APPLICATION, adapter: SocketProfile = ADAPTER
) -> AsyncIterator[Gateway]:
    """Run a gateway for as long as the block does.

    Args:
        settings: what its owner sets.
        application: the bounds of connections of applications.
        adapter: the bounds of connections of adapters.

    Raises:
        OSError: the port is taken, or the address is not this machine's.
        JournalUnusable: the journal's file is that of something else, or of another gateway.
        ValueError: a key, a certificate or a list cannot be used.
    """
    async with AsyncExitStack() as stack:
        ice = IceServers(settings.ice_servers, settings.turn, settings.turn_secret, settings.turn_ttl, time.time)
        parts = await stack.enter_async_context(Clustering.opened(settings))
        audit = stack.enter_context(Audit(settings.audit_file, redact=Redaction(settings.secrets())))
        journal: Journal = NoJournal() if parts is None else parts.journal
        if settings.journal is not None:
            journal = stack.enter_context(SqliteJournal(settings.journal))
        # What runs ends before that is written down no more.
        tasks = await stack.enter_async_context(TaskScope())
        lag = LoopLag()
        tasks.start(lag.watch())
        host = EngineHost(
            Engine(settings.engine_id),
            tasks,
            ice_servers=ice.servers,
            ice_ttl=ice.ttl,
            audit=audit,
            journal=journal,
            lease_rules=Rules(settings.lease_grace, settings.lease_answer, settings.lease_loan),
            # Greater than those of a process before this one, as long as the wall clock is not set back.
            epochs=CountedEpochs(round(time.time() * 1000)) if parts is None else parts.epochs,
            unread=UnreadBudget(settings.unread),
            quotas=SubjectQuotas(settings.subject_connections, settings.subject_sessions, settings.subject_streams),
            ranks=Ranks.parse(settings.ranks),
        )
        auth_setup = AuthSetup.open(settings, audit, tasks, host.connection_stats.turn_away)
        readiness = Readiness()
        readiness.require("time: it is draining", lambda: not host.draining)
        readiness.require("audit trail", lambda: audit.is_kept)
        readiness.require("journal", lambda: not journal.failing)
        if (verifier := auth_setup.admission.verifier) is not None:
            readiness.require("keys for tokens", verifier.keys.is_usable)
        header_timeouts = HeaderTimeouts(host.connection_stats.turn_away, settings.silent, settings.silent_per_address)
        restart_barrier = RestartBarrier(host)
        readiness.require("adapters: those of before the restart", lambda: restart_barrier.is_over)
        connection_limits = ConnectionLimits(
            host.connection_stats.turn_away,
            settings.most_applications,
            settings.most_adapters,
            settings.per_address,
            restart_barrier.wait,
        )
        readiness.require("room for connections", lambda: not connection_limits.is_full)
        clustering = None
        if parts is not None:
            clustering = Clustering(parts, host)
            await stack.enter_async_context(clustering.serving(auth_setup, readiness))
        server = _Server(
            settings, host, auth_setup, connection_limits, header_timeouts, readiness, application, adapter, clustering
        )
        runner = web.AppRunner(server.app, shutdown_timeout=_SHUTDOWN_TIMEOUT)
        await runner.setup()
        stack.push_async_callback(runner.cleanup)
        stack.enter_context(restart_barrier.watching())
        context = None if auth_setup.certificate is None else auth_setup.certificate.context
        assert runner.server is not None
        loop = asyncio.get_running_loop()
        connections = partial(HttpConnection, runner.server, header_timeouts, loop=loop, **OPTIONS)
        port = await stack.enter_async_context(
            serving_tcp(settings.host, settings.port, header_timeouts, connections, context)
        )
        drain = Drain(host, settings.drain)
        if clustering is not None:
            federation = clustering.federation
            drain = Drain(
                *(host, settings.drain),
                relayed=lambda: federation.relayed,
                has_others=lambda: bool(federation.others),
                settle=clustering.settle,
            )
        shown = f"[{settings.host}]" if ":" in settings.host else settings.host
        metrics = ""
        if settings.metrics is not None:
            keys = None if verifier is None else verifier.keys
            sources = Sources(
                host,
                lag,
                header_timeouts,
                connection_limits,
                keys,
                auth_setup.reloader,
                auth_setup.certificate,
                clustering,
            )
            look = partial(figures, sources)
            serving = serving_metrics(
                *metrics_address(settings.metrics), look, settings.metrics_token, host.connection_stats.turn_away
            )
            metrics = await stack.enter_async_context(serving)
            _log.info("metrics: %s", metrics)
        scheme = "http" if context is None else "https"
        url = f"{scheme}://{shown}:{port}/"
        yield Gateway(
            url,
            host.engine,
            metrics,
            lambda: auth_setup.reloader.reload_changed(at_all=True),
            drain.run,
            None if clustering is None else clustering.federation,
        )


class _Server:
    """The HTTP side: paths, admission, and the sockets that are open."""

    def __init__(
        self,
        settings: GatewaySettings,
        host: EngineHost,
        auth_setup: AuthSetup,
        connection_limits: ConnectionLimits,
        header_timeouts: HeaderTimeouts,
        readiness: Readiness,
        application: SocketProfile,
        adapter: SocketProfile,
        clustering: Clustering | None,
    ) -> None:
        self._host = host
        self._clustering = clustering
        self._federation = None if clustering is None else clustering.federation
        self._claims = None if clustering is None else clustering.claims
        self._auth_setup = auth_setup
        self._connection_limits = connection_limits
        self._adapter_timeout = settings.adapter_timeout
        self._stall_timeout = settings.stall_timeout
        self._application_profile = application
        self._adapter_profile = adapter
        self._sockets: set[ServerSocket] = set()
        self.app = web.Application(middlewares=[header_timeouts.middleware(), guard(auth_setup.admission)])
        self.app.router.add_get("/healthz", healthz)
        self.app.router.add_get("/readyz", partial(readyz, readiness, settings.metrics_token))
        self.app.router.add_get("/admitted", self._admitted)
        self.app.router.add_get("/page-token", self._page_token)
        self.app.router.add_get("/adapter", self._adapter)
        self.app.router.add_get("/{path:.*}", self._page_or_application)
        self.app.on_shutdown.append(self._close_all)

    async def _page_or_application(self, request: web.Request) -> web.StreamResponse:
        if _wants_websocket(request):
            expiry = TokenExpiry(await self._auth_setup.admission.application(request), address=request.remote or "")
            return await self._serve(
                request,
                self._application_profile,
                expiry,
                self._place_of_application(expiry),
                self._connection_limits.entering(),
                lambda stream: serve_application(
                    self._host, stream, expiry, self._auth_setup.renewal, self._auth_setup.sign_ins, self._federation
                ),
            )
        path = request.match_info["path"]
        if path == _OPENRPC:
            return web.Response(body=openrpc(), content_type="application/json")
        return page_response(path)

    @contextmanager
    def _place_of_application(self, expiry: TokenExpiry) -> Iterator[None]:
        with ExitStack() as stack:
            stack.enter_context(self._connection_limits.of_application(expiry.address))
            if expiry.principal is not LOCAL:
                # Without tokens each connection is a subject of its own, and has one of each.
                try:
                    stack.enter_context(self._host.quotas.connected(quota_name(expiry.principal, "")))
                except OutOfResources as error:
                    self._host.connection_stats.turn_away("too many of one subject")
                    raise web.HTTPTooManyRequests(text=f"{error}\n") from None
            yield

    async def _admitted(self, request: web.Request) -> web.Response:
        """Answer as a WebSocket would be: a browser does not tell its page why one was refused."""
        await self._auth_setup.admission.application(request)
        return web.json_response({"status": "ok", "tokens": self._auth_setup.admission.verifier is not None})

    async def _page_token(self, request: web.Request) -> web.Response:
        """Give the gateway's page a token, a new one of the visitor whose token it shows, where visitors bring none."""
        if self._auth_setup.page_tokens is None:
            return web.Response(status=204)
        try:
            principal = await self._auth_setup.admission.application(request)
        except web.HTTPUnauthorized:
            # A token of before this gateway was started: with none the page would be given one, too.
            principal = LOCAL
        token = self._auth_setup.page_tokens.issue(principal)
        # Created: the page is another visitor now.
        status = 201 if principal is LOCAL else 200
        return web.json_response({"token": token}, status=status, headers={"Cache-Control": "no-store"})

    async def _adapter(self, request: web.Request) -> web.StreamResponse:
        if not _wants_websocket(request):
            raise web.HTTPUpgradeRequired(text="adapters connect here by WebSocket\n")
        expiry = TokenExpiry(await self._auth_setup.admission.adapter(request), address=request.remote or "")
        return await self._serve(
            request,
            self._adapter_profile,
            expiry,
            self._connection_limits.of_adapter(),
            nullcontext(),
            lambda stream: serve_adapter(
                self._host,
                stream,
                self._adapter_timeout,
                expiry=expiry,
                renewal=self._auth_setup.renewal,
                sign_ins=self._auth_setup.sign_ins,
                ownership=self._claims,
            ),
        )

    async def _serve(
        self,
        request: web.Request,
        profile: SocketProfile,
        expiry: TokenExpiry,
        place: AbstractContextManager[None],
        entering: AbstractAsyncContextManager[None],
        serve: Callable[[MessageStream], Awaitable[object]],
    ) -> web.StreamResponse:
        with place:
            socket = ServerSocket(
                request, profile, stalling=Stalling(self._stall_timeout), on_cut=self._host.connection_stats.cut_off
            )
            try:
                async with entering:
                    self._require_open()
                    await socket.prepare()
            except StreamClosed:
                # aiohttp needs an answer, and drops it: the connection is gone.
                return web.Response()
            self._sockets.add(socket)
            pinging = asyncio.ensure_future(socket.keep_alive())
            try:
                with self._auth_setup.expiries.holding(expiry, socket):
                    closed = await serve(socket)
                _log.debug("%s: %s", request.path, closed)
            finally:
                self._sockets.discard(socket)
                pinging.cancel()
                await asyncio.wait({pinging})
            return socket.response

    def _require_open(self) -> None:
        if self._host.draining:
            self._host.connection_stats.turn_away("draining")
            raise web.HTTPServiceUnavailable(text=f"{RESTARTS}\n", headers={"Retry-After": str(RETRY_AFTER)})

    async def _close_all(self, _app: web.Application) -> None:
        if self._clustering is not None:
            await self._clustering.settle()
        await asyncio.gather(
            *(socket.close(WSCloseCode.GOING_AWAY, "the gateway stops") for socket in tuple(self._sockets))
        )


def _wants_websocket(request: web.Request) -> bool:
    return request.headers.get("Upgrade", "").lower() == "websocket"
