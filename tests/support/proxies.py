"""haproxy in front of a gateway, as an operator would have it, and impatient."""

import asyncio
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

from tests.support.demo import free_port

__all__ = ["IDLE", "Proxy", "proxy"]

IDLE = 1.0
"""Seconds after which it cuts a connection over which nothing passes."""
_PATIENCE = 30.0


class Proxy:
    """The proxy process, which can be stopped and started again.

    Attributes:
        url: where the gateway is reached through it.
    """

    def __init__(self, target: str, folder: Path) -> None:
        port = free_port()
        self.url = f"http://127.0.0.1:{port}/"
        self._port = port
        self._process: asyncio.subprocess.Process | None = None
        self._file = folder / "haproxy.cfg"
        waits = "".join(f" timeout {what} {IDLE * 1000:.0f}ms\n" for what in ("connect", "client", "server", "tunnel"))
        self._file.write_text(
            f"defaults\n mode http\n{waits}"
            f"frontend page\n bind 127.0.0.1:{port}\n default_backend gateway\n"
            f"backend gateway\n server one {urlsplit(target).netloc}\n"
        )

    async def start(self) -> None:
        """Start it, and wait until it listens."""
        program = shutil.which("haproxy")
        assert program is not None
        quiet = asyncio.subprocess.DEVNULL
        self._process = await asyncio.create_subprocess_exec(
            program, "-db", "-f", str(self._file), stdout=quiet, stderr=quiet
        )
        async with asyncio.timeout(_PATIENCE):
            while True:
                with suppress(OSError):
                    _, writer = await asyncio.open_connection("127.0.0.1", self._port)
                    writer.close()
                    await writer.wait_closed()
                    return
                await asyncio.sleep(0.02)

    async def kill(self) -> None:
        """End it, and with it all connections."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()


@asynccontextmanager
async def proxy(target: str, folder: Path) -> AsyncIterator[Proxy]:
    """Run one while the block runs."""
    made = Proxy(target, folder)
    await made.start()
    try:
        yield made
    finally:
        await made.kill()
