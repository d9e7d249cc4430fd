"""`openrois bench stop`: how long STOP and a dead man's switch take beside viewers that flood the engine."""

import asyncio
import os
import random
import signal
import time
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final

from openrois.client import Client, ComponentProxy
from openrois.errors import RoISError
from openrois_bench.errors import within
from openrois_bench.faults.stop_report import Load, Run, StopReport
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MICROSECONDS, Percentiles
from openrois_bench.processes.child import Child
from openrois_bench.processes.partner import Partner, partner
from openrois_bench.viewing.adapter import COMPONENT_REF, ENGINE_ID, STOPPED, WHEEL_REF
from openrois_bench.viewing.product import Product, product

__all__ = ["StopSettings", "run_stop"]

_PAUSE: Final = 0.05
"""Seconds between two STOPs, on average."""
_SETTLING: Final = 1.0
_DEAD_MAN_TRY: Final = 2.0
"""Seconds that a try of the dead man's switch has."""
_PATIENCE: Final = 60.0
"""Seconds that anything may take that is not measured."""


@dataclass(frozen=True, slots=True)
class StopSettings:
    """Settings of the measurement.

    Attributes:
        seconds: of STOPs under each load.
        dead_man: tries of the dead man's switch under each.
        reports: authentic RTCP packets a second of one viewer.
        strangers: datagrams a second that prove nothing.
        viewers: that join meanwhile.
        engine: what the pictures are of.
    """

    seconds: float = 20.0
    dead_man: int = 5
    reports: float = 5_000
    strangers: float = 20_000
    viewers: int = 64
    engine: str = "synthetic"

    @property
    def loads(self) -> tuple[Load, ...]:
        """Idle, and then each flood beside those that join, and both."""
        return (
            Load(name="idle"),
            Load(name="authentic RTCP", reports=self.reports, viewers=self.viewers),
            Load(name="strangers", strangers=self.strangers, viewers=self.viewers),
            Load(name="both", reports=self.reports, strangers=self.strangers, viewers=self.viewers),
        )


async def run_stop(settings: StopSettings, progress: Callable[[str], None]) -> StopReport:
    """Measure; `progress` is told what comes next.

    Raises:
        BenchFailed: something did not do what it should.
    """
    before = load()
    cores = sorted(os.sched_getaffinity(0))
    pinned = len(cores) > 1
    runs = []
    async with _pinned_product(cores[0] if pinned else None) as (served, stopped):
        with _pinned(cores[-1] if pinned else None):
            async with (
                partner("openrois_bench.faults.crowd") as watcher,
                partner("openrois_bench.faults.crowd") as crowd,
            ):
                told = {"url": served.url, "component_ref": COMPONENT_REF}
                targets = (await watcher.ask("watch", told, within=_PATIENCE))["targets"]
                for each in settings.loads:
                    progress(f"STOP, {each.name}")
                    asked = {**told, "targets": targets, **each.model_dump(exclude={"name"})}
                    runs.append(await _Measuring(settings, served, stopped, watcher, crowd).run(each, asked))
    return StopReport(
        engine=settings.engine,
        conditions=conditions(before),
        seconds=settings.seconds,
        pinned=pinned,
        runs=tuple(runs),
    )


class _Measuring:
    """One run."""

    def __init__(
        self,
        settings: StopSettings,
        served: Product,
        stopped: "asyncio.Queue[float]",
        watcher: Partner,
        crowd: Partner,
    ) -> None:
        self._settings = settings
        self._served = served
        self._stopped = stopped
        self._watcher = watcher
        self._crowd = crowd
        self._order = random.Random(1)

    async def run(self, load: Load, asked: Mapping[str, Any]) -> Run:
        seconds = _SETTLING + self._settings.seconds + self._settings.dead_man * _DEAD_MAN_TRY
        harassing = asyncio.ensure_future(
            self._crowd.ask("harass", {**asked, "seconds": seconds}, within=seconds + _PATIENCE)
        )
        adapter = Child(self._served.adapter, "")
        try:
            async with Client(self._served.url) as client:
                wheel = client.component(WHEEL_REF)
                async with wheel.bound():
                    await asyncio.sleep(_SETTLING)
                    before, used = await self._watcher.ask("seen", {}, within=_PATIENCE), adapter.cpu()
                    waits, unconfirmed = await self._stops(client, wheel)
                    after, used = await self._watcher.ask("seen", {}, within=_PATIENCE), adapter.cpu() - used
                    dead_man = [await self._dead_man(wheel) for _ in range(self._settings.dead_man)]
            done = await harassing
        finally:
            harassing.cancel()
            await asyncio.gather(harassing, return_exceptions=True)
        took = after["at"] - before["at"]
        return Run(
            load=load,
            **done,
            stops=Percentiles.of(waits, MICROSECONDS),
            unconfirmed=unconfirmed,
            dead_man=tuple(dead_man),
            pictures=(after["pictures"] - before["pictures"]) / took,
            adapter=used / took,
            viewer_ended=after["bye"],
        )

    async def _stops(self, client: Client, wheel: ComponentProxy) -> tuple[list[float], int]:
        waits, unconfirmed, end = [], 0, time.monotonic() + self._settings.seconds
        while time.monotonic() < end:
            turning = await wheel.command("start").execute()
            await asyncio.sleep(self._order.uniform(0.5, 1.5) * _PAUSE)
            began = time.monotonic()
            try:
                if WHEEL_REF not in await client.control.stop_all(ENGINE_ID):
                    unconfirmed += 1
            except RoISError:
                unconfirmed += 1
            waits.append(time.monotonic() - began)
            await _over(turning)
        return waits, unconfirmed

    async def _dead_man(self, wheel: ComponentProxy) -> float:
        """Have the wheel turn and the gateway fall silent; returns how many milliseconds the wheel turned on."""
        turning = await wheel.command("start").execute()
        await asyncio.sleep(self._order.uniform(0.3, 0.5))
        began = stopped = time.monotonic()
        os.kill(self._served.gateway, signal.SIGSTOP)
        try:
            async with within(_DEAD_MAN_TRY, "the dead man's switch"):
                while stopped <= began:  # what is left in the pipe tells of earlier stops
                    stopped = await self._stopped.get()
        finally:
            os.kill(self._served.gateway, signal.SIGCONT)
        await _over(turning)
        return (stopped - began) * 1000


async def _over(command: Any) -> None:
    """Wait until a command has ended, in whichever way."""
    async with within(_PATIENCE, "the end of a command"):
        with suppress(RoISError):
            await command


@asynccontextmanager
async def _pinned_product(core: int | None) -> AsyncIterator[tuple[Product, "asyncio.Queue[float]"]]:
    """Run the product on one core; yields it, and the times at which its wheel has stopped."""
    stopped: asyncio.Queue[float] = asyncio.Queue()

    def heard(line: str) -> None:
        if line.startswith(STOPPED):
            stopped.put_nowait(float(line.removeprefix(STOPPED)))

    everything = os.sched_getaffinity(0)
    if core is not None:
        os.sched_setaffinity(0, {core})  # what is started now inherits it
    try:
        async with product(640, 360, on_line=heard) as served:
            os.sched_setaffinity(0, everything)
            yield served, stopped
    finally:
        os.sched_setaffinity(0, everything)


@contextmanager
def _pinned(core: int | None) -> Iterator[None]:
    """Keep this process, and what it starts, to one core."""
    everything = os.sched_getaffinity(0)
    if core is not None:
        os.sched_setaffinity(0, {core})
    try:
        yield
    finally:
        os.sched_setaffinity(0, everything)
