"""One listener, a process of its own: it receives all that the first visitor sends, and decodes it.

Run by `__main__` as `python -m openrois_bench.streams.visitors.listener URL`.
"""

import asyncio
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import Any

from openrois_media import Media
from openrois_media.client.readers import StreamReader

from openrois.aio.tasks import TaskScope
from openrois.client import Client
from openrois.jsonrpc.session import Handler
from openrois.types.codes import Purpose
from openrois_bench.processes.partner import serve
from openrois_bench.viewing.adapter import ENGINE_ID


class _Count:
    """How much came of one device."""

    def __init__(self) -> None:
        self.items = 0
        self.came = asyncio.Event()

    async def count_items(self, reader: StreamReader[Any]) -> None:
        async for _ in reader:
            self.items += 1
            self.came.set()


@asynccontextmanager
async def _listening(url: str) -> AsyncIterator[Mapping[str, Handler]]:
    async with (
        Client(url, reconnect=None) as client,
        Media(client) as media,
        AsyncExitStack() as stack,
        TaskScope() as tasks,
    ):
        visitor = (await media.visitors(ENGINE_ID, purposes=[Purpose.LIVE]))[0]
        counts: dict[str, _Count] = {}
        for device in visitor.devices:
            source = visitor.camera.frames("i420") if device == "camera" else visitor.microphone.blocks()
            reader: StreamReader[Any] = await stack.enter_async_context(source)
            counts[device] = _Count()
            tasks.start(counts[device].count_items(reader))

        async def run(_params: Mapping[str, Any]) -> None:
            """Answer when something of each device has come."""
            for each in counts.values():
                await each.came.wait()

        async def count(_params: Mapping[str, Any]) -> dict[str, int]:
            """Return how much has come so far."""
            return {device: each.items for device, each in counts.items()}

        yield {"run": run, "count": count}


if __name__ == "__main__":
    serve(partial(_listening, sys.argv[1]))
