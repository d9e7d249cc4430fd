"""Serves one host over standard input and output: one process, one caller, one body at a time."""

import asyncio
import os
import signal
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from mcp.server.lowlevel import NotificationOptions
from mcp.server.stdio import stdio_server

from openrois.aio.tasks import TaskScope
from openrois_agents.mcp.server import build_server
from openrois_agents.tools.settings import ToolSettings

if TYPE_CHECKING:
    from openrois.client import Client
    from openrois_agents.mcp.handlers import Handlers
    from openrois_agents.mcp.only_caller import OnlyCaller

__all__ = ["serve_stdio"]


class _Loader:
    """Loads the tools with the first request that is more than a greeting."""

    def __init__(self, make_client: Callable[[], "Client"], settings: ToolSettings) -> None:
        self._make_client = make_client
        self._settings = settings
        self._caller: OnlyCaller | None = None

    def load(self) -> "Handlers":
        """Return what handles requests."""
        if self._caller is None:
            # A host waits for its greeting, and takes longer to ask for more.
            from openrois_agents.mcp import only_caller

            self._caller = only_caller.OnlyCaller(self._make_client, self._settings)
        return self._caller.handlers

    async def leave(self) -> None:
        """Stop what runs, give the body back and take leave of the gateway."""
        if self._caller is not None:
            await self._caller.leave()


async def serve_stdio(make_client: Callable[[], "Client"], settings: ToolSettings) -> None:
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
    loader = _Loader(make_client, settings)
    async with TaskScope() as tasks:
        serving = tasks.start(_serve(loader))
        ending = tasks.start(_wait(told_to_end))
        await asyncio.wait({serving, ending}, return_when=asyncio.FIRST_COMPLETED)
        await loader.leave()
        if not serving.done():
            os._exit(0)


async def _serve(loader: _Loader) -> None:
    server = build_server(loader.load)
    options = server.create_initialization_options(NotificationOptions(tools_changed=True, resources_changed=True))
    async with stdio_server() as (reading, writing):
        await server.run(reading, writing, options)


async def _wait(event: asyncio.Event) -> None:
    await event.wait()
