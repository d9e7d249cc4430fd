"""A stage for faults: a gateway, robots behind it, a relay between them, and invariants checked in the end."""

import asyncio
import os
import random
import ssl
import sys
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import pytest
from aiohttp import ClientSession

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway import server
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.gateway.socket import ADAPTER, APPLICATION
from openrois.session.session import EngineHost
from openrois.testing import FaultRelay
from openrois.transport import silence
from tests.support.components import Bell, Lamp
from tests.support.invariants import LONGEST_BLOCK, PATIENCE, Book, Witness, calm, check_audit

__all__ = ["Child", "Ground", "ground", "program", "robot_program", "turns"]

QUICK: Final = [replace(profile, ping_interval=0.1, ping_timeout=0.3) for profile in (APPLICATION, ADAPTER)]
"""Pings that find a silent side in 0.4 s."""

_ROOT: Final = Path(__file__).parents[2]


async def turns(chance: random.Random, most: int = 20) -> None:
    """Let the loop turn by chance some times: what happens next happens at another moment."""
    for _ in range(chance.randrange(most)):
        await asyncio.sleep(0)


@dataclass
class Ground:
    """One gateway and what is around it.

    Attributes:
        gateway: it.
        host: its engine, and what its sessions share.
        relay: stands between robots and gateway, and between those applications and it that go through it.
        chance: of this seed.
        book: what was heard.
        tls: with what applications connect; None for no TLS.
    """

    gateway: Gateway
    host: EngineHost
    relay: FaultRelay
    chance: random.Random
    stack: AsyncExitStack
    lamp: Lamp = field(default_factory=Lamp)
    bell: Bell = field(default_factory=Bell)
    book: Book = field(default_factory=Book)
    tls: ssl.SSLContext | None = None

    async def witness(self, *, relayed: bool = False, **options: Any) -> Witness:
        """Connect one more application."""
        url = self.relay.url if relayed else self.gateway.url
        options |= {} if self.tls is None else {"ssl": self.tls}
        return await self.stack.enter_async_context(self.book.witness(url, **options))

    @property
    def adapter_url(self) -> str:
        """Where robots dial, through the relay."""
        return f"{self.relay.url.replace('http', 'ws', 1)}adapter"

    async def robot(
        self, *components: Component, engine_id: str = "robot", relayed: bool = True, url: str = ""
    ) -> None:
        """Let a robot of this process dial, which dials again at once whenever its connection has ended.

        Args:
            components: of the robot, in place of a lamp and a bell.
            engine_id: of the robot.
            relayed: through the relay, or straight to the gateway.
            url: of the gateway, where it is reached in another way.
        """
        scope = await self.stack.enter_async_context(TaskScope())
        engine = Engine(engine_id)
        await engine.attach(LocalRegistry(engine_id, components or (self.lamp, self.bell)))
        dialling = await self.stack.enter_async_context(TaskScope())
        url = url or (self.relay.url if relayed else self.gateway.url)
        url = f"{url.replace('http', 'ws', 1)}adapter"
        dialling.start(serve_parent(EngineHost(engine, scope), url, sleep=_briefly))
        await self.attached(engine_id)

    async def attached(self, engine_id: str = "robot", *, there: bool = True) -> None:
        """Wait until an engine is there, or is not."""
        changed = asyncio.Event()
        stop = self.gateway.engine.on_change(changed.set)
        try:
            async with asyncio.timeout(PATIENCE):
                while (engine_id in self.gateway.engine.directory.profile.engine_ids()) is not there:
                    changed.clear()
                    await changed.wait()
        finally:
            stop()

    async def running(self, count: int = 1) -> None:
        """Wait until so many commands have been accepted and not ended."""
        async with asyncio.timeout(PATIENCE):
            while self.host.commands.taken != count:
                await turns(self.chance)


async def _briefly(_seconds: float) -> None:
    await asyncio.sleep(0.002)


@asynccontextmanager
async def ground(
    seed: int,
    folder: Path,
    log: pytest.LogCaptureFixture,
    *,
    quick: bool = False,
    ready: bool = True,
    audited: bool = True,
    longest: float = LONGEST_BLOCK,
    tls: ssl.SSLContext | None = None,
    **settings: Any,
) -> AsyncIterator[Ground]:
    """Run a gateway behind a relay for one seed of one fault; in the end the rules are checked.

    Args:
        seed: of all chance.
        folder: for the audit trail.
        log: of the test.
        quick: silent sides are found soon.
        ready: the gateway has to be ready in the end.
        audited: there is an audit trail to be checked.
        longest: seconds of processor time that one turn of the loop, with gateway, robots and applications, may take.
        tls: what knows the gateway's certificate, where it has one.
        settings: of the gateway.
    """
    chance, hosts = random.Random(seed), list[EngineHost]()

    def make(*arguments: Any, **options: Any) -> EngineHost:
        hosts.append(EngineHost(*arguments, **options))
        return hosts[-1]

    audit = folder / "audit.jsonl"
    chosen = {"port": 0, "audit_file": audit if audited else None} | settings
    application, adapter = QUICK if quick else (APPLICATION, ADAPTER)
    with pytest.MonkeyPatch.context() as lasting:
        if quick:
            # Who answers is in this process too, and stands still with it for moments where the machine is busy.
            lasting.setattr(silence, "STOOD_STILL", 0.1)
        async with calm(log, longest):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(server, "EngineHost", make)
                running = run_gateway(GatewaySettings(**chosen), application=application, adapter=adapter)
                gateway = await running.__aenter__()
            try:
                async with FaultRelay(gateway.url, seed=seed) as relay:
                    async with AsyncExitStack() as stack:
                        place = Ground(gateway, hosts[0], relay, chance, stack, tls=tls)
                        yield place
                    await _check_left(place, ready=ready)
            finally:
                await running.__aexit__(*sys.exc_info())
    place.book.check()
    if audited:
        check_audit(audit, commands=place.book.accepted)


async def _check_left(place: Ground, *, ready: bool) -> None:
    """Check that the gateway lives and nothing is left of closed sessions (I5, I8)."""
    async with ClientSession() as http, http.get(f"{place.gateway.url}readyz", ssl=place.tls or True) as answer:
        assert not ready or answer.status == 200, await answer.text()
    options: dict[str, Any] = {} if place.tls is None else {"ssl": place.tls}
    async with Book().witness(place.gateway.url, **options) as fresh:
        assert await fresh.code("rois.system.get_profile", condition="") == "OK"
    host = place.host
    async with asyncio.timeout(PATIENCE):
        while _left(host):  # noqa: ASYNC110 - they end by themselves
            await asyncio.sleep(0.001)


def _left(host: EngineHost) -> dict[str, object]:
    """Return what there still is of applications and robots."""
    held = {
        ref: held for ref, held in host.leases.model.holding._held.items() if held[0] not in host.leases.model.absent
    }
    left = {
        "commands": host.commands.taken,
        "text of commands": host.commands.text,
        "accepted": host.pending.components(),
        "leases": held,
        "engines": host.engine.directory.profile.engine_ids()[1:],
        "subscriptions": len(host.engine._subscriptions),
        "sessions": host.connection_stats.sessions("application") + host.connection_stats.sessions("adapter"),
    }
    return {name: value for name, value in left.items() if value}


class Child:
    """A process of ours: a gateway, or a robot.

    Attributes:
        process: it.
        first: the first line that it printed, if it prints one.
    """

    def __init__(self, process: asyncio.subprocess.Process, first: str, log: Path) -> None:
        self.process = process
        self.first = first
        self._log = log

    def signal(self, number: int) -> None:
        self.process.send_signal(number)

    async def line(self) -> str:
        """Wait for the next line that it prints."""
        assert self.process.stdout is not None
        async with asyncio.timeout(PATIENCE * 3):
            return (await self.process.stdout.readline()).decode().strip()

    async def ended(self) -> int:
        """Wait for its end and return its exit status."""
        async with asyncio.timeout(PATIENCE * 3):
            return await self.process.wait()

    def log(self) -> str:
        """What it wrote to standard error."""
        return self._log.read_text()


@asynccontextmanager
async def program(
    *arguments: str, log: Path, prints: bool = False, prefix: tuple[str, ...] = (), **options: Any
) -> AsyncIterator[Child]:
    """Run a Python program while the block runs; `prefix` is a command that runs it somewhere else."""
    with log.open("a") as errors:
        process = await asyncio.create_subprocess_exec(
            *prefix,
            sys.executable,
            *arguments,
            cwd=_ROOT,
            env=os.environ | {"PYTHONUNBUFFERED": "1"},
            stdout=asyncio.subprocess.PIPE,
            stderr=errors,
            **options,
        )
    assert process.stdout is not None
    try:
        async with asyncio.timeout(PATIENCE * 3):
            first = (await process.stdout.readline()).decode().strip() if prints else ""
        yield Child(process, first, log)
    finally:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                process.kill()
        await process.wait()
        process._transport.close()  # type: ignore[attr-defined]


def gateway_program(*options: str, log: Path, **more: Any) -> Any:
    """Run `openrois gateway` as a process; it prints where it listens."""
    return program("-m", "openrois.cli", "gateway", *options, log=log, prints=True, **more)


def robot_program(url: str, *, log: Path, engine_id: str = "robot") -> Any:
    """Run a robot with a lamp and a bell as a process."""
    return program("-m", "tests.support.robot_child", url, engine_id, log=log)
