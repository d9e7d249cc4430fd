"""Hosts of the Model Context Protocol in tests: the real library's client, and a body behind a gateway in memory."""

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

from mcp.client.client import Client as Host
from mcp_types import CallToolResult, TextResourceContents
from openrois_agents.mcp.handlers import Handlers
from openrois_agents.mcp.server import build_server
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

from openrois.client import Client
from openrois.testing import MemoryGateway, memory_gateway
from tests.support.actors import Actor, Visitors

PATIENCE = 30.0
"""Seconds after which a test gives up waiting for something that comes at once."""

Generation = Literal["legacy", "auto"]

GENERATIONS: tuple[Generation, ...] = ("legacy", "auto")
"""The handshake of the older protocols, and the newest."""


@dataclass
class Finder:
    """Finds the one session that there is."""

    session: Session

    async def find_session(self, _request: Any) -> Session:
        return self.session


@dataclass
class Table:
    """A host, its session, the body, and its gateway where that is in memory."""

    host: Host
    session: Session
    actor: Actor
    gateway: MemoryGateway | None = None
    progress: list[str] = field(default_factory=list)
    reported: asyncio.Event = field(default_factory=asyncio.Event)

    async def call(self, tool: str, /, **arguments: Any) -> CallToolResult:
        async def note(progress: float, total: float | None, message: str | None) -> None:
            self.progress.append(message or "")
            self.reported.set()

        return await self.host.call_tool(tool, arguments, progress_callback=note)

    async def until(self, message: str) -> None:
        """Wait until this was reported as the progress of a call."""
        async with asyncio.timeout(PATIENCE):
            while message not in self.progress:
                self.reported.clear()
                await self.reported.wait()

    async def said(self, tool: str, /, **arguments: Any) -> str:
        """Call a tool that succeeds, and return its text."""
        result = await self.call(tool, **arguments)
        assert not result.is_error, text_of(result)
        return text_of(result)

    async def document(self, address: str) -> str:
        """Return the text of a document."""
        (content,) = (await self.host.read_resource(address)).contents
        assert isinstance(content, TextResourceContents)
        return content.text

    async def refused(self, tool: str, /, **arguments: Any) -> str:
        """Call a tool that fails, and return its sentence."""
        result = await self.call(tool, **arguments)
        assert result.is_error, text_of(result)
        assert text_of(result).startswith(f"{result.structured_content['error']}: ")
        return text_of(result)


def text_of(result: CallToolResult) -> str:
    """Return the texts of a result."""
    return "\n".join(each.text for each in result.content if each.type == "text")


@asynccontextmanager
async def session_at(make_client: Callable[[], Client], settings: ToolSettings | None = None) -> AsyncIterator[Session]:
    """Run a session for as long as the block does."""
    async with Session(make_client, settings or ToolSettings()) as session:
        yield session


@asynccontextmanager
async def table(
    *,
    actor: Actor | None = None,
    settings: ToolSettings | None = None,
    mode: Generation = "auto",
) -> AsyncIterator[Table]:
    """Run a host with a body behind a gateway in memory."""
    actor = actor or Actor(visitors=Visitors({}))
    async with (
        memory_gateway(*actor.parts) as gateway,
        session_at(gateway.client, settings) as session,
        Host(build_server(partial(_same, Handlers(Finder(session)))), mode=mode) as host,
    ):
        yield Table(host, session, actor, gateway)


def _same(handlers: Handlers) -> Handlers:
    return handlers


def names(texts: Sequence[Any]) -> list[str]:
    """Return the names of what a host has listed."""
    return [each.name for each in texts]
