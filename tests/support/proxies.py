"""haproxy in front of a gateway, as an operator would have it, and impatient; or in front of those of a cluster."""

import asyncio
import csv
import shutil
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tests.support.demo import free_port

__all__ = ["IDLE", "Proxy", "proxy"]

IDLE = 1.0
"""Seconds after which it cuts a connection over which nothing passes."""
_PATIENCE = 30.0


class Proxy:
    """The proxy process, which can be stopped and started again.

    Of several gateways each takes its turn while it is ready; a connection to one that is not is ended.

    Args:
        targets: addresses of the gateways.
        folder: for its configuration.
        idle: seconds after which it cuts a connection over which nothing passes.
        balance: which gateway has the next connection: `roundrobin`, or `first`, which is the first that is ready.
        weights: of the gateways, for their shares of the connections; none for equal ones.

    Attributes:
        url: where a gateway is reached through it.
    """

    def __init__(
        self,
        targets: Sequence[str],
        folder: Path,
        idle: float = IDLE,
        balance: str = "roundrobin",
        weights: Sequence[int] = (),
    ) -> None:
        port, self._admin_port = free_port(), free_port()
        self.url = f"http://127.0.0.1:{port}/"
        self._port = port
        self._process: asyncio.subprocess.Process | None = None
        self._file = folder / "haproxy.cfg"
        waits = "".join(f" timeout {what} {idle * 1000:.0f}ms\n" for what in ("connect", "client", "server", "tunnel"))
        checked = " check inter 200ms fall 2 rise 1 on-marked-down shutdown-sessions" if len(targets) > 1 else ""
        servers = "".join(
            f" server gateway{number} {urlsplit(target).netloc}{checked} weight {weight}\n"
            for number, (target, weight) in enumerate(zip(targets, weights or [1] * len(targets), strict=True))
        )
        self._file.write_text(
            f"global\n stats socket ipv4@127.0.0.1:{self._admin_port} level admin\n"
            f"defaults\n mode http\n{waits}"
            f"frontend page\n bind 127.0.0.1:{port}\n default_backend gateway\n"
            f"backend gateway\n balance {balance}\n option httpchk GET /readyz\n"
            f" option redispatch\n retries 3\n{servers}"
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

    async def ask(self, command: str) -> str:
        """Give it a command over its socket for operators, and return what it says."""
        async with asyncio.timeout(_PATIENCE):
            reader, writer = await asyncio.open_connection("127.0.0.1", self._admin_port)
            writer.write(f"{command}\n".encode())
            said = (await reader.read()).decode()
            writer.close()
            await writer.wait_closed()
        return said

    async def connections(self) -> list[int]:
        """Return how many connections there are now to each gateway."""
        rows = csv.DictReader((await self.ask("show stat")).removeprefix("# ").splitlines())
        return [int(row["scur"]) for row in rows if row["pxname"] == "gateway" and row["svname"].startswith("gateway")]

    async def set_weight(self, number: int, weight: int) -> None:
        """Give a gateway another share of the connections that come; those that are there stay."""
        assert not (await self.ask(f"set weight gateway/gateway{number} {weight}")).strip()

    async def kill(self) -> None:
        """End it, and with it all connections."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()


@asynccontextmanager
async def proxy(*targets: str, folder: Path, **options: Any) -> AsyncIterator[Proxy]:
    """Run one while the block runs."""
    made = Proxy(targets, folder, **options)
    await made.start()
    try:
        yield made
    finally:
        await made.kill()
