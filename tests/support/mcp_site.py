"""A gateway with a body on real sockets, and hosts of the Model Context Protocol that use it over HTTP or a process."""

import asyncio
import os
import sys
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any

import httpx2
from mcp.client.client import Client as Host
from mcp.client.stdio import StdioServerParameters, stdio_client
from mcp.client.streamable_http import streamable_http_client
from mcp.shared._httpx_utils import create_mcp_http_client
from openrois_agents.mcp.guard import host_rules
from openrois_agents.mcp.http_server import PATH, HttpServer, listen
from openrois_agents.tools.settings import ToolSettings

from openrois.adapter.running import serve
from openrois.client import Client
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.actors import Actor
from tests.support.mcp_hosts import PATIENCE, Generation
from tests.support.tokens import issue, key_file

__all__ = ["Site", "agent_token", "bearer", "hosted_at", "site", "started"]


def agent_token(subject: str, **claims: object) -> str:
    """Return a good token of an agent."""
    return issue(time.time(), sub=subject, scope=["*/*"], **claims)


class Site:
    """A gateway, and its body.

    Attributes:
        url: where applications connect.
        reload: lets the gateway read its files again.
        actor: the body.
        tools: where `openrois mcp` serves it over HTTP; empty unless it does.
    """

    def __init__(self, gateway: Gateway, actor: Actor) -> None:
        self.url = gateway.url.replace("http", "ws", 1)
        self.reload = gateway.reload
        self.actor = actor
        self.tools = ""

    async def is_free(self, token: str | None = None) -> bool:
        """Tell whether no application holds any part of the body."""
        async with Client(self.url, token=token) as client:
            (info,) = await client.bodies()
            return bool(info.free)

    async def until_free(self, token: str | None = None) -> None:
        """Wait until no application holds any part of the body."""
        async with asyncio.timeout(PATIENCE):
            while not await self.is_free(token):
                pass


@asynccontextmanager
async def site(
    folder: Path,
    *,
    actor: Actor | None = None,
    with_tokens: bool = True,
    http: ToolSettings | None = None,
    **settings: Any,
) -> AsyncIterator[Site]:
    """Run a gateway with a body, and the tools over HTTP where their settings are given."""
    actor = actor or Actor()
    if with_tokens:
        settings["auth_keys"] = (key_file(folder),)
    token_file = folder / "adapter.token"
    token_file.write_text(issue(time.time(), sub="robot", roles=["adapter"], scope=["robot/*"]))
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(run_gateway(GatewaySettings(port=0, **settings)))
        opened = Site(gateway, actor)
        there = asyncio.Event()
        gateway.engine.on_change(there.set)
        await stack.enter_async_context(
            serve(*actor.parts, engine_id="robot", gateway=f"{opened.url}adapter", token_file=token_file)
        )
        async with asyncio.timeout(PATIENCE):
            await there.wait()
        if http is not None:
            listening = listen("127.0.0.1", 0)
            opened.tools = f"http://127.0.0.1:{listening.getsockname()[1]}{PATH}"

            def make_client(token: Any) -> Client:
                return Client(opened.url, token=token)

            rules = host_rules("127.0.0.1", (), ("https://app.example.org",))
            server = HttpServer(rules, make_client, http)
            serving = asyncio.ensure_future(server.serve(listening))
            stack.push_async_callback(_ended, server, serving)
        yield opened


async def _ended(server: HttpServer, serving: "asyncio.Task[None]") -> None:
    server.end_serving()
    async with asyncio.timeout(PATIENCE):
        await serving


def bearer(token: str) -> httpx2.AsyncClient:
    """Return a client of HTTP that shows a token."""
    return create_mcp_http_client(headers={"Authorization": f"Bearer {token}"})


@asynccontextmanager
async def hosted_at(address: str, token: str, mode: Generation = "auto") -> AsyncIterator[Host]:
    """Connect a host over HTTP, with a token of its own."""
    async with (
        bearer(token) as http,
        Host(streamable_http_client(address, http_client=http), mode=mode) as host,
    ):
        yield host


@asynccontextmanager
async def started(
    url: str, *options: str, mode: Generation = "auto", token_file: Path | None = None
) -> AsyncIterator[Host]:
    """Start `openrois mcp` as a host does, and connect to it over its standard input and output."""
    shown = () if token_file is None else ("--token-file", str(token_file))
    arguments = ["-m", "openrois.cli", "mcp", "--gateway", url, *shown, *options]
    process = StdioServerParameters(command=sys.executable, args=arguments, env=dict(os.environ))
    async with Host(stdio_client(process), mode=mode) as host:
        yield host
