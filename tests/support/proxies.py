"""haproxy in front of gateways: the configuration that is shipped, or an impatient one in front of a single gateway."""

import asyncio
import re
import shutil
import tempfile
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

from tests.support.demo import free_port
from tests.support.gateway_processes import until
from tests.support.packages import ROOT

__all__ = ["IDLE", "SHIPPED", "Proxy", "ShippedProxy", "proxy", "shipped", "shipped_proxy"]

IDLE: Final = 1.0
"""Seconds after which it cuts a connection over which nothing passes."""

SHIPPED: Final = ROOT / "packaging/haproxy.cfg"

_PATIENCE: Final = 30.0


class Proxy:
    """The proxy process, which can be stopped and started again.

    Args:
        configuration: what it does.
        port: where it does that.
        folder: for its configuration.

    Attributes:
        url: where a gateway is reached through it.
    """

    def __init__(self, configuration: str, port: int, folder: Path) -> None:
        self.url = f"http://127.0.0.1:{port}/"
        self._port = port
        self._process: asyncio.subprocess.Process | None = None
        self._file = folder / "haproxy.cfg"
        self._file.write_text(configuration)

    async def start(self) -> None:
        """Start it, and wait until it listens."""
        program = shutil.which("haproxy")
        assert program is not None
        quiet = asyncio.subprocess.DEVNULL
        self._process = await asyncio.create_subprocess_exec(
            program, "-db", "-f", str(self._file), stdout=quiet, stderr=quiet
        )
        await until(self._is_there, "the proxy does not listen", _PATIENCE)

    async def _is_there(self) -> bool:
        with suppress(OSError):
            _, writer = await asyncio.open_connection("127.0.0.1", self._port)
            writer.close()
            await writer.wait_closed()
            return True
        return False

    async def kill(self) -> None:
        """End it, and with it all connections."""
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()


@asynccontextmanager
async def proxy(target: str, *, folder: Path, idle: float = IDLE) -> AsyncIterator[Proxy]:
    """Run one in front of a gateway while the block runs; it cuts a connection over which nothing passes."""
    port = free_port()
    waits = "".join(f" timeout {what} {idle * 1000:.0f}ms\n" for what in ("connect", "client", "server", "tunnel"))
    configuration = (
        f"defaults\n mode http\n{waits}frontend page\n bind 127.0.0.1:{port}\n default_backend gateway\n"
        f"backend gateway\n server gateway {urlsplit(target).netloc}\n"
    )
    made = Proxy(configuration, port, folder)
    async with _running(made):
        yield made


class ShippedProxy(Proxy):
    """The shipped configuration in front of three gateways, with other addresses.

    Attributes:
        socket: where it is asked and told things while it runs.
    """

    def __init__(self, targets: Sequence[str], folder: Path, balance: str, weights: Sequence[int]) -> None:
        port = free_port()
        self.socket = folder / "admin.sock"
        super().__init__(shipped(targets, port, self.socket, balance, weights), port, folder)

    async def _is_there(self) -> bool:
        # No connection of these tests' own is spread among the gateways.
        with suppress(OSError):
            return bool(await self.ask("show info"))
        return False

    async def ask(self, command: str) -> str:
        """Return what it answers to a command."""
        reader, writer = await asyncio.open_unix_connection(str(self.socket))
        try:
            writer.write(f"{command}\n".encode())
            return (await reader.read()).decode()
        finally:
            writer.close()

    async def shown(self, column: str, backend: str = "ready") -> dict[str, str]:
        """Return one column of its statistics, by server."""
        names, *rows = (line.split(",") for line in (await self.ask(f"show stat {backend} 4 -1")).strip().splitlines())
        return {row[1]: row[names.index(column)] for row in rows}

    async def takes_for(self, *states: str, backend: str = "ready") -> None:
        """Wait until it takes its gateways, in their order, for these: `UP`, `NOLB` (no new connections), `DOWN`."""

        async def is_so() -> bool:
            # One that changes is `UP 1/2`.
            return [status.split()[0] for status in (await self.shown("status", backend)).values()] == list(states)

        await until(is_so, f"the proxy does not take its gateways for {', '.join(states)}", _PATIENCE)

    async def connections(self, backend: str = "ready") -> list[int]:
        """Return how many connections there are now to each gateway."""
        return list(map(int, (await self.shown("scur", backend)).values()))

    async def set_weight(self, number: int, weight: int) -> None:
        """Give a gateway another share of the connections that come; those that are there stay."""
        assert not (await self.ask(f"set server ready/{'abc'[number]} weight {weight}")).strip()

    async def spread(self, holds: Callable[[list[int]], bool], backend: str = "ready") -> list[int]:
        """Wait until something holds for the numbers of connections to its gateways, and return these."""
        counts: list[int] = []

        async def is_so() -> bool:
            nonlocal counts
            counts = await self.connections(backend)
            return holds(counts)

        await until(is_so, "the proxy does not spread connections as expected", _PATIENCE)
        return counts


@asynccontextmanager
async def shipped_proxy(
    *targets: str, balance: str = "leastconn", weights: Sequence[int] = ()
) -> AsyncIterator[ShippedProxy]:
    """Run it in front of three gateways while the block runs.

    Args:
        targets: addresses of the gateways.
        balance: which gateway has the next connection: as it is shipped, or `first`, which is the first that is ready.
        weights: of the gateways, for their shares of the connections; none for equal ones.
    """
    # The path of a socket is short.
    with tempfile.TemporaryDirectory(prefix="or-ha-") as folder:
        made = ShippedProxy(targets, Path(folder), balance, weights)
        async with _running(made):
            yield made


def shipped(
    targets: Sequence[str], port: int, socket: Path, balance: str = "leastconn", weights: Sequence[int] = ()
) -> str:
    """Return the shipped configuration with other addresses, and for who may not change to another user."""
    changes = [
        (r"^    (user|group) haproxy\n", "", 2),
        (r"/run/haproxy/admin\.sock", str(socket), 1),
        (r"bind :8765", f"bind 127.0.0.1:{port}", 1),
        ("balance leastconn", f"balance {balance}", 1),
    ]
    for name, target, weight in zip("abc", targets, weights or [100] * len(targets), strict=True):
        changes.append((rf"gateway-{name}\.example\.org:8765", f"{urlsplit(target).netloc} weight {weight}", 2))
    if urlsplit(targets[0]).scheme == "http":
        changes.append((" check-ssl verify none", "", 1))
    text = SHIPPED.read_text(encoding="utf-8")
    for pattern, new, times in changes:
        text, count = re.subn(pattern, new, text, flags=re.MULTILINE)
        assert count == times, f"{pattern} stands {count} times in {SHIPPED.name}"
    return text


@asynccontextmanager
async def _running(made: Proxy) -> AsyncIterator[None]:
    await made.start()
    try:
        yield
    finally:
        await made.kill()
