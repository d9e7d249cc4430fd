"""Serves one host over standard input and output: one process, one caller, one body at a time."""

import asyncio
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from mcp.server.lowlevel import NotificationOptions
from mcp.server.stdio import stdio_server

from openrois.aio.tasks import TaskScope
from openrois.client import Client
from openrois_agents.mcp.server import build_server
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

__all__ = ["serve_stdio"]


class _OnlySession:
    """Finds the session of the one caller."""

    def __init__(self, session: Session) -> None:
        self._session = session

    async def find_session(self, _request: Any) -> Session:
        return self._session


async def serve_stdio(make_client: Callable[[], Client], settings: ToolSettings) -> None:
    """Serve the host until it closes standard input, or this process is told to end.

    Then what the tools began is stopped, and the body is given back. Told to end, this process does: a thread that
    waits for standard input cannot be ended otherwise.

    Args:
        make_client: returns a client with the token of this process.
        settings: of the tools.
    """
    told_to_end = asyncio.Event()
    with suppress(NotImplementedError):
        for name in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(name, told_to_end.set)
    async with TaskScope() as tasks:
        async with Session(make_client, settings) as session:
            serving = tasks.start(_serve(session))
            ending = tasks.start(_wait(told_to_end))
            await asyncio.wait({serving, ending}, return_when=asyncio.FIRST_COMPLETED)
        if not serving.done():
            os._exit(0)


async def _serve(session: Session) -> None:
    server = build_server(_OnlySession(session))
    options = server.create_initialization_options(NotificationOptions(tools_changed=True))
    async with stdio_server() as (reading, writing):
        await server.run(reading, writing, options)


async def _wait(event: asyncio.Event) -> None:
    await event.wait()
