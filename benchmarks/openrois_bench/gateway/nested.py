"""A change of one body behind a gateway that stands behind another one: by the directory, and by the whole profile.

`python -m openrois_bench.gateway.nested`, in the repository. Two gateways with equal bodies of 17 components stand
behind two others; of one pair the outer gateway hides that it knows `openrois.directory`, so that it reads the whole
profile at each change. In turns one body behind each changes. It runs in one process, because it is the sum for both
gateways that is measured:

* characters between the two gateways for one change;
* CPU of both for one change, and until it can be found at the outer gateway;
* characters that an application there gets, which speaks `openrois.directory`.
"""

import argparse
import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.contract import Directory
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.adapters import serve_adapter
from openrois.gateway.applications import serve_application
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier
from openrois_bench.errors import within
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table

__all__ = ["Change", "measure"]

SIZES: Final = (100, 1_000)
ROUNDS: Final = 8
"""Changes of each pair: fewer than are notified in a burst."""
_PATIENCE: Final = 60.0
_DIRECTORY: Final = '"openrois.directory",'


class Body(LocalRegistry):
    """A body that is described and nothing else; it has one component less after each second change."""

    def __init__(self, engine_id: str) -> None:
        super().__init__(engine_id, ())
        self.is_whole = True

    async def discover(self) -> Directory:
        """Return what it offers now."""
        kinds = BASIC_COMPONENTS if self.is_whole else BASIC_COMPONENTS[1:]
        profiles = {f"{self.engine_id}/{kind.name}": kind.profile() for kind in kinds}
        engine = HRIEngineProfile(identifier=RoISIdentifier(code=self.engine_id), component_ids=tuple(profiles))
        return Directory(engine, profiles)


class Counted:
    """A stream that counts what comes, and may leave the directory out of what the other side says it knows."""

    def __init__(self, stream: MemoryStream, *, hides_directory: bool) -> None:
        self._stream = stream
        self._hides_directory = hides_directory
        self.characters = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    async def receive(self) -> str:
        """Return the next text."""
        text = await self._stream.receive()
        self.characters += len(text)
        return text.replace(_DIRECTORY, "") if self._hides_directory and "openrois.hello" in text else text


@dataclass(frozen=True)
class Change:
    """What one change took.

    Attributes:
        characters: between the gateways.
        cpu_ms: of both.
        seconds: until the outer one has it.
        told: characters that an application got.
    """

    characters: int
    cpu_ms: float
    seconds: float
    told: int


@dataclass
class Pair:
    """A gateway with bodies behind another one.

    Attributes:
        inner: the engine with the bodies.
        outer: the host of the other one.
        streams: both ends of the connection between them.
        told: what applications of the outer one get.
    """

    inner: Engine
    bodies: list[Body]
    outer: EngineHost
    streams: tuple[Counted, Counted]
    told: Counted
    found: list[Change] = field(default_factory=list)

    async def change(self, body: Body) -> Change:
        """Change a body; return what that took."""
        ref = f"{body.engine_id}/{BASIC_COMPONENTS[0].name}"
        characters = sum(each.characters for each in self.streams)
        began, before = time.perf_counter(), time.process_time()
        told = self.told.characters
        changed = asyncio.Event()
        stop = self.outer.engine.on_change(changed.set)
        body.is_whole = not body.is_whole
        await self.inner.refresh(body)
        async with within(_PATIENCE, "a change behind the inner gateway"):
            while (ref in self.outer.engine.components) != body.is_whole:
                changed.clear()
                await changed.wait()
        seconds = time.perf_counter() - began
        stop()
        # Applications are notified in the same turn; what they get has to be read.
        await asyncio.sleep(0.2)
        used = (time.process_time() - before) * 1000
        return Change(
            sum(each.characters for each in self.streams) - characters, used, seconds, self.told.characters - told
        )


@asynccontextmanager
async def _pair(name: str, size: int, *, hides_directory: bool) -> AsyncIterator[Pair]:
    inner = Engine(f"inner-{name}")
    bodies = [Body(f"{name}-{number:05}") for number in range(size)]
    for body in bodies:
        await inner.attach(body)
    near, far = memory_pair()
    application, seen = memory_pair()
    async with AsyncExitStack() as stack:
        outer = EngineHost(Engine("outer"), await stack.enter_async_context(TaskScope()))
        served = EngineHost(inner, await stack.enter_async_context(TaskScope()))
        streams = (Counted(near, hides_directory=False), Counted(far, hides_directory=hides_directory))
        told = Counted(application, hides_directory=False)
        serving = (
            serve_adapter(outer, streams[0]),
            serve_engine(served, streams[1]),
            serve_application(outer, seen),
            _read(told),
        )
        attached = asyncio.Event()
        stop = outer.engine.on_change(attached.set)
        tasks = [asyncio.ensure_future(each) for each in serving]
        hello = {"version": "1", "extensions": ["openrois.directory"]}
        await application.send(json.dumps({"jsonrpc": "2.0", "id": 1, "method": "openrois.hello", "params": hello}))
        try:
            async with within(_PATIENCE, "attaching the inner gateway"):
                await attached.wait()
            stop()
            yield Pair(inner, bodies, outer, streams, told)
        finally:
            await near.close()
            await application.close()
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks)


async def _read(stream: Counted) -> None:
    while True:
        await stream.receive()


async def measure(size: int, rounds: int = ROUNDS) -> dict[str, list[Change]]:
    """Return the changes of both pairs, which take turns."""
    async with _pair("whole", size, hides_directory=True) as whole, _pair("read", size, hides_directory=False) as read:
        pairs = {"whole profile": whole, "directory": read}
        for number in range(rounds):
            for pair in pairs.values():
                pair.found.append(await pair.change(pair.bodies[number // 2]))
        return {name: pair.found for name, pair in pairs.items()}


def main() -> None:
    """Measure at each size, and print a table."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.gateway.nested", description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="bodies behind the inner gateway")
    parser.add_argument("--json", type=Path, help="write what was measured to this file")
    options = parser.parse_args()
    before = load()
    rows, results = [], []
    for size in options.sizes:
        for way, changes in asyncio.run(measure(size)).items():
            row = {
                "characters": int(median(each.characters for each in changes)),
                "cpu_ms": median(each.cpu_ms for each in changes),
                "seconds": median(each.seconds for each in changes),
                "told": int(median(each.told for each in changes)),
            }
            results.append({"bodies": size, "way": way, **row})
            rows.append(
                (
                    str(size),
                    way,
                    f"{row['characters']}",
                    f"{row['cpu_ms']:.1f}",
                    f"{row['seconds']:.3f}",
                    f"{row['told']}",
                )
            )
    print(table(("bodies", "read by", "characters", "CPU ms", "s", "told"), rows))
    write_result(options.json, "openrois_bench.gateway.nested", conditions(before), changes=results)


if __name__ == "__main__":
    main()
