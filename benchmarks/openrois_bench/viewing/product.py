"""Measured product: a gateway and, behind it, an adapter with test pictures, each a process of its own."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final
from urllib.parse import urlsplit

from openrois_body.processes.child import Output, child_process
from openrois_streaming.clock import SystemClock

from openrois.client import Client
from openrois_bench.errors import BenchFailed, within
from openrois_bench.viewing.adapter import COMPONENT_REF, Show

__all__ = ["Product", "product"]

_START_TIMEOUT: Final = 30.0
_LISTENING: Final = "listening "


@dataclass(frozen=True, slots=True)
class Product:
    """A gateway with an adapter behind it.

    Attributes:
        host: `host:port` of the gateway.
        gateway: the gateway's process id.
        adapter: the adapter's.
    """

    host: str
    gateway: int
    adapter: int

    @property
    def url(self) -> str:
        """The WebSocket address for applications."""
        return f"ws://{self.host}/"


@asynccontextmanager
async def product(
    width: int, height: int, fps: float = 30, show: Show = "bars", on_line: Callable[[str], None] | None = None
) -> AsyncIterator[Product]:
    """Run a gateway and, behind it, an adapter with such pictures; `on_line` gets what the adapter prints.

    Raises:
        BenchFailed: it does not start.
    """
    clock = SystemClock()
    said = Output("gateway", clock)
    arguments = ("openrois.cli", "gateway", "--port", "0")
    async with child_process(*arguments, output=said, conversation=True) as gateway:
        assert gateway.stdout is not None
        async with within(_START_TIMEOUT, "the start of the gateway"):
            line = (await gateway.stdout.readline()).decode()
        if not line.startswith(_LISTENING):
            raise BenchFailed(f"the gateway does not start: {said.last_words}")
        host = urlsplit(line.removeprefix(_LISTENING).strip()).netloc
        adapter = ("openrois_bench.viewing.adapter", f"ws://{host}/adapter", str(width), str(height), str(fps), show)
        said = Output("adapter", clock, on_line)
        async with child_process(*adapter, output=said) as process:
            served = Product(host, gateway.pid, process.pid)
            await _attached(served.url, process, said)
            yield served


async def _attached(url: str, adapter: asyncio.subprocess.Process, said: Output) -> None:
    """Wait until the gateway knows the adapter."""
    async with within(_START_TIMEOUT, "the start of the adapter"), Client(url) as client:
        while COMPONENT_REF not in await client.search():
            if adapter.returncode is not None:
                raise BenchFailed(f"the adapter does not start: {said.last_words}")
            await asyncio.sleep(0.1)
