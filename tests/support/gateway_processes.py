"""Gateways of one cluster as processes, which are killed, stopped and drained; and haproxy in front of them."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from aiohttp import ClientError, ClientSession, ClientTimeout

from tests.support.demo import free_port
from tests.support.nats import NatsServer, cluster_name, freeze
from tests.support.packages import ROOT
from tests.support.postgres import Server

__all__ = ["OPENROIS", "GatewayProcess", "GatewayProcesses", "Own", "gateway_processes", "until"]

PATIENCE: Final = 60.0
"""Seconds that anything may take on a busy machine."""

OPENROIS: Final = (sys.executable, "-m", "openrois.cli")
"""The program of a gateway."""

_LOOK: Final = 0.02


@dataclass(frozen=True, slots=True)
class Own:
    """What one gateway has otherwise than the others.

    Attributes:
        nats: the address of its way to NATS; empty for the straight one.
        store: the URL of its way to PostgreSQL; empty for the straight one.
        program: runs it; another version, or with another clock.
        options: of it alone.
    """

    nats: str = ""
    store: str = ""
    program: tuple[str, ...] = OPENROIS
    options: tuple[str, ...] = ()


_NOTHING: Final[Mapping[str, Own]] = MappingProxyType({})


async def until(holds: Callable[[], Awaitable[bool]], what: str, within: float = PATIENCE) -> float:
    """Wait until something holds; return the seconds that it took."""
    loop = asyncio.get_running_loop()
    began = loop.time()
    try:
        async with asyncio.timeout(within):
            while not await holds():  # noqa: ASYNC110 - other processes tell nothing
                await asyncio.sleep(_LOOK)
    except TimeoutError:
        raise TimeoutError(f"after {within:.0f} s: {what}") from None
    return loop.time() - began


class GatewayProcess:
    """One gateway, which keeps its address when it is started again.

    Attributes:
        gateway_id: of it.
        url: where applications and adapters find it.
        log: what all its processes wrote.
        program: runs it from the next start on.
    """

    def __init__(
        self, gateway_id: str, folder: Path, options: Iterable[str], program: Iterable[str], scheme: str = "http"
    ) -> None:
        port = free_port()
        self.gateway_id = gateway_id
        self.url = f"{scheme}://127.0.0.1:{port}/"
        self.log = folder / f"gateway-{gateway_id}.log"
        self.program = tuple(program)
        self._words = ("gateway", "--port", str(port), "--gateway-id", gateway_id, *options)
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start it; it is not ready yet."""
        with self.log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *self.program, *self._words, cwd=ROOT, stdout=log, stderr=log, env=os.environ
            )

    async def run(self, *more: str) -> tuple[int, str]:
        """Run its program with its options and more to its end; return the exit status, and what it wrote."""
        once = await asyncio.create_subprocess_exec(
            *self.program,
            *(*self._words, *more),
            cwd=ROOT,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )
        async with asyncio.timeout(PATIENCE):
            said, _ = await once.communicate()
        return once.returncode or 0, said.decode()

    async def restart(self, program: Iterable[str] = ()) -> None:
        """Stop it in good order, start it again, by another program where that is given, and wait until it is ready."""
        self.signal(signal.SIGTERM)
        assert await self.ended() == 0
        self.program = tuple(program) or self.program
        await self.start()
        await self.ready()

    async def ready(self) -> float:
        """Wait until it says that it is ready; return the seconds that it took.

        One that could not start, because the store was slow for a moment, is started again, as by its unit of systemd.
        """

        async def is_so() -> bool:
            if not self.is_running:
                await self.start()
            return (await self.readiness())[0] == 200

        return await until(is_so, f"{self.gateway_id} is not ready:\n{self.said()}")

    async def lacks(self, what: str) -> float:
        """Wait until it says that it lacks something; return the seconds that it took."""

        async def is_so() -> bool:
            _, told = await self.readiness()
            return told is not None and what in told.get("lacking", ())

        return await until(is_so, f"{self.gateway_id} does not lack {what}:\n{self.said()}")

    async def readiness(self) -> tuple[int, Any]:
        """Return the status and the answer of `/readyz`; 0 where there is none within a second."""
        with suppress(ClientError, TimeoutError, OSError):
            timeout = ClientTimeout(1.0)
            async with ClientSession(timeout=timeout) as http, http.get(f"{self.url}readyz", ssl=False) as answer:
                return answer.status, await answer.json()
        return 0, None

    async def kill(self) -> None:
        """Kill it, and wait until it is gone."""
        self.signal(signal.SIGKILL)
        await self.ended()

    def freeze(self) -> None:
        """Let it stand still."""
        assert self._process is not None
        freeze(self._process.pid)

    def thaw(self) -> None:
        """Let it go on."""
        self.signal(signal.SIGCONT)

    def signal(self, number: int) -> None:
        assert self._process is not None
        with suppress(ProcessLookupError):
            self._process.send_signal(number)

    async def ended(self) -> int:
        """Wait for its end, and return its exit status."""
        assert self._process is not None
        async with asyncio.timeout(PATIENCE):
            return await self._process.wait()

    @property
    def adapter_url(self) -> str:
        """Where adapters dial it."""
        return f"{self.url.replace('http', 'ws', 1)}adapter"

    @property
    def is_running(self) -> bool:
        """Whether there is a process that has not ended."""
        return self._process is not None and self._process.returncode is None

    def said(self) -> str:
        """What all its processes wrote."""
        return self.log.read_text(errors="replace") if self.log.exists() else ""


class GatewayProcesses:
    """The gateways of a cluster.

    Attributes:
        nats: joins them.
        postgres: has what they share.
        gateways: they, by id.
    """

    def __init__(
        self,
        nats: NatsServer,
        postgres: Server,
        folder: Path,
        ids: str,
        options: Iterable[str] = (),
        own: Mapping[str, Own] = _NOTHING,
        scheme: str = "http",
    ) -> None:
        self.nats = nats
        self.postgres = postgres
        self.gateways = {}
        shared = ("--cluster-name", cluster_name(), "--store-password", str(postgres.password_file), *options)
        for each in ids:
            has = own.get(each, Own())
            found = ("--cluster", has.nats or nats.url, "--store", has.store or postgres.url)
            self.gateways[each] = GatewayProcess(each, folder, (*found, *shared, *has.options), has.program, scheme)

    def __getitem__(self, gateway_id: str) -> GatewayProcess:
        return self.gateways[gateway_id]

    def others(self, *but: str) -> list[GatewayProcess]:
        """Return the gateways but these."""
        return [each for each in self.gateways.values() if each.gateway_id not in but]

    async def owner(self, engine_id: str, *but: str) -> GatewayProcess:
        """Wait until an engine has an owner, which is none of `but`, and return that."""
        found = ""

        async def is_owned() -> bool:
            nonlocal found
            found = await self.owner_id(engine_id)
            return bool(found) and found not in but

        await until(is_owned, f"{engine_id} has no owner but {found!r}")
        return self.gateways[found]

    async def owner_id(self, engine_id: str) -> str:
        """Return the gateway that owns an engine, as PostgreSQL has it; empty for none."""
        async with self.postgres.admin() as admin:
            return str(
                await admin.fetchval("SELECT gateway_id FROM openrois.claim WHERE engine_id = $1", engine_id) or ""
            )

    def said(self) -> str:
        """What all of them wrote, for the reader of a failed run."""
        return "\n".join(f"--- gateway {each.gateway_id}\n{each.said()}" for each in self.gateways.values())


@asynccontextmanager
async def gateway_processes(
    nats: NatsServer,
    postgres: Server,
    folder: Path,
    ids: str = "abc",
    *,
    options: Iterable[str] = (),
    own: Mapping[str, Own] = _NOTHING,
    scheme: str = "http",
) -> AsyncIterator[GatewayProcesses]:
    """Run gateways with an empty store while the block runs; what they wrote is added to a failure.

    Their addresses begin with `https` where the options give them a certificate.
    """
    async with postgres.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    running = GatewayProcesses(nats, postgres, folder, ids, options, own, scheme)
    try:
        for each in running.gateways.values():
            await each.start()
        for each in running.gateways.values():
            await each.ready()
        yield running
    except BaseException as error:
        error.add_note(running.said())
        raise
    finally:
        for each in running.gateways.values():
            if each.is_running:
                await each.kill()
