"""Serves many callers over streamable HTTP, each with its own token."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import uvicorn
from mcp.server.auth.middleware.bearer_auth import AuthenticatedUser
from mcp.server.auth.provider import AccessToken
from mcp.server.transport_security import TransportSecuritySettings
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from openrois_agents.mcp.callers import Callers, MakeClient
from openrois_agents.mcp.guard import GuardRules, Refused, bearer_of
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.mcp.server import build_server
from openrois_agents.tools.settings import ToolSettings

__all__ = ["PATH", "HttpServer", "listen"]

PATH: Final = "/mcp"
"""Where the tools are."""

MAX_BODY: Final = 256 * 1024
"""Bytes of one request."""

MAX_CONNECTIONS: Final = 256
"""Connections and requests at a time; more are answered 503."""

MAX_HEAD: Final = 32 * 1024
"""Bytes of the head of a request."""

MAX_HTTP_SESSIONS: Final = 256
"""Sessions of the older generation of the protocol; they end half an hour after their last request."""

_FAREWELL: Final = 1
"""Seconds that calls have to end when the server ends."""

_CHALLENGE: Final = {"WWW-Authenticate": 'Bearer realm="openrois"'}


class _Guarded:
    """Serves what the guard lets through, as the caller whose token it carries."""

    def __init__(self, app: ASGIApp, rules: GuardRules, callers: Callers) -> None:
        self._app = app
        self._rules = rules
        self._callers = callers

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            try:
                self._rules.check(scope["headers"])
                caller = await self._callers.admit(bearer_of(scope["headers"]))
            except Refused as refused:
                headers = _CHALLENGE if refused.status == 401 else None
                await PlainTextResponse(f"{refused}\n", refused.status, headers)(scope, receive, send)
                return
            # The library lets no other caller use a session that this one has begun.
            user = AuthenticatedUser(AccessToken(token="", client_id=caller.key, scopes=[]))
            scope = {**scope, "openrois.caller": caller, "user": user}
        await self._app(scope, receive, send)


class _Server(uvicorn.Server):
    """A server that leaves signals alone: bodies are given back after it has ended, and before the process does."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture none."""
        yield


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens.

    Raises:
        OSError: it cannot.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    return socket.create_server((host, port), family=family, backlog=128)


class HttpServer:
    """Serves callers over HTTP until it is ended.

    Args:
        rules: what a request has to name.
        make_client: returns clients of the gateway.
        tools: settings of the tools.
    """

    def __init__(self, rules: GuardRules, make_client: MakeClient, tools: ToolSettings) -> None:
        self._callers = Callers(make_client, tools)
        handlers = Handlers(self._callers)
        app = build_server(lambda: handlers).streamable_http_app(
            streamable_http_path=PATH,
            max_request_body_size=MAX_BODY,
            max_sessions=MAX_HTTP_SESSIONS,
            # The guard checks what these would, and before anything is read.
            transport_security=TransportSecuritySettings(enable_dns_rebinding_protection=False),
        )
        config = uvicorn.Config(
            _Guarded(app, rules, self._callers),
            log_config=None,
            access_log=False,
            server_header=False,
            ws="none",
            lifespan="on",
            limit_concurrency=MAX_CONNECTIONS,
            h11_max_incomplete_event_size=MAX_HEAD,
            timeout_graceful_shutdown=_FAREWELL,
        )
        self._server = _Server(config)

    def end_serving(self) -> None:
        """Serve no more requests."""
        self._server.should_exit = True

    async def serve(self, listening: socket.socket) -> None:
        """Serve until `end_serving`; then all that callers began is stopped, and every body given back.

        Args:
            listening: where to accept connections.
        """
        async with self._callers:
            await self._server.serve(sockets=[listening])
