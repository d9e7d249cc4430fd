"""How long a picture stands still when a gateway is killed: media goes past the gateways.

    python -m openrois_bench.cluster.picture [--rounds N] [--json FILE]

NATS, PostgreSQL, three gateways and a body with a camera, each a process of its own. Viewers in this process receive
the picture over WebRTC. The body's gateway is killed, which one of two viewers has for its own, and in every other
round that of a viewer alone. Each round is watched for longer than the body lets streams go on whose gateway was lost,
so that the change to the streams in their place counts.
"""

import argparse
import asyncio
import time
from collections.abc import AsyncIterable, AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import uvloop
from openrois_media import Media, VideoSource, serve
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import ColourBars

from openrois.client import Client, Notification, Reconnect
from openrois.remote.serve import STREAM_GRACE
from openrois.types.codes import StreamStatus
from openrois.types.streams import StreamStatusNotification
from openrois_bench.cluster.gateways import PATIENCE, Cluster, Gateway, dialling, three_gateways
from openrois_bench.cluster.reporting import measure_and_report
from openrois_bench.errors import within
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import child

__all__ = ["CASES", "Case", "measure", "printed", "summary"]

CASES: Final = ("that of the body and the viewer", "that of the body", "that of the viewer")
SIZE: Final = (320, 180)
FPS: Final = 30.0

WATCHED: Final = STREAM_GRACE + 3.0
"""Seconds before and after a kill in which the longest gap is looked for."""


@dataclass(slots=True)
class Case:
    """What was measured of one case: seconds, of each round.

    Attributes:
        before: the longest gap between two pictures before the kill.
        after: the longest one from the last picture before the kill on.
        replaced: from the kill until a new stream had taken the place of the one that was lost.
    """

    before: list[float] = field(default_factory=list)
    after: list[float] = field(default_factory=list)
    replaced: list[float] = field(default_factory=list)


async def be_body(engine_id: str, urls: Sequence[str]) -> None:
    """Serve a body with a camera to the first of some gateways that is there, for ever."""
    camera = VideoSource(ColourBars(*SIZE, FPS, clock=SystemClock()), size=SIZE, frame_rate=FPS)
    async with serve(engine_id=engine_id, streams={"camera": camera}, gateway=urls):
        print("dialling", flush=True)
        await asyncio.Event().wait()


class Viewer:
    """A viewer that notes when pictures of a camera come.

    Attributes:
        arrivals: of pictures, by this process's clock.
        running: when each of the streams that it has had was running first, by its id.
    """

    def __init__(self, camera: str) -> None:
        self._camera = camera
        self.arrivals: list[float] = []
        self.running: dict[str, float] = {}

    @asynccontextmanager
    async def watching(self, urls: Sequence[str]) -> AsyncIterator[None]:
        """Watch through the first of some gateways that is there."""
        async with AsyncExitStack() as stack:
            client = Client(dial=dialling(urls), reconnect=Reconnect(first=0.1, limit=0.5))
            await stack.enter_async_context(client)
            async with within(PATIENCE, "the body, as the viewer sees it"):
                while self._camera not in await client.search():  # noqa: ASYNC110 - a gateway learns of it from another one
                    await asyncio.sleep(0.05)
            media = await stack.enter_async_context(Media(client))
            told = client.notifications(StreamStatusNotification.method)
            frames = await stack.enter_async_context(media.frames(self._camera, "i420", timeout=PATIENCE))
            async with asyncio.TaskGroup() as tasks:
                reading = tasks.create_task(self._read(frames))
                noting = tasks.create_task(self._note(told))
                yield
                reading.cancel()
                noting.cancel()

    async def _read(self, frames: AsyncIterable[object]) -> None:
        async for _ in frames:
            self.arrivals.append(time.perf_counter())

    async def _note(self, notifications: AsyncIterable[Notification]) -> None:
        async for told in notifications:
            if told.params["status"] == StreamStatus.STREAMING_RUNNING.value:
                self.running.setdefault(told.params["stream_id"], time.perf_counter())

    async def sees(self, streams: int) -> None:
        """Wait until it has had so many streams, and a picture."""
        async with within(PATIENCE, "the picture" if streams == 1 else "a stream in the place of the lost one"):
            while len(self.running) < streams or not self.arrivals:  # noqa: ASYNC110 - it is noted elsewhere
                await asyncio.sleep(0.02)

    def longest(self, begin: float, end: float) -> float:
        """Return the longest gap between two pictures in a time; the last one before it begins that, too."""
        first = max((at for at in self.arrivals if at <= begin), default=begin)
        moments = [first, *(at for at in self.arrivals if begin < at <= end), end]
        return max(later - earlier for earlier, later in pairwise(moments))


async def measure(rounds: int, progress: Callable[[str], None], watched: float = WATCHED) -> dict[str, Case]:
    """Kill a gateway so many times: the body's, and in every other round that of a viewer alone.

    Args:
        rounds: kills.
        progress: called after each of them.
        watched: seconds before and after a kill in which the longest gap is looked for.

    Raises:
        BenchFailed: something that takes part did not do what it should.
    """
    cases = {name: Case() for name in CASES}
    async with three_gateways() as running:
        for number in range(rounds):
            names = CASES[2:] if number % 2 else CASES[:2]
            found = {name: cases[name] for name in names}
            killed = await _one_round(f"body-{number}", running, found, watched)
            await killed.start()
            progress(f"round {number + 1} of {rounds}")
    return cases


async def _one_round(engine_id: str, running: Cluster, cases: Mapping[str, Case], watched: float) -> Gateway:
    """Kill the gateway of some cases; return it."""
    async with AsyncExitStack() as stack:
        await stack.enter_async_context(
            child("-P", "-m", "openrois_bench.cluster.picture", "--be-body", engine_id, *running.urls)
        )
        owner = await running.owner_of(engine_id)
        front, other = (each for each in running.gateways.values() if each is not owner)
        victim = front if CASES[2] in cases else owner
        viewers = {name: Viewer(f"{engine_id}/camera") for name in cases}
        for name, viewer in viewers.items():
            ways = (owner, front, other) if name == CASES[0] else (front, other, owner)
            await stack.enter_async_context(viewer.watching([each.url for each in ways]))
            await viewer.sees(1)
        await asyncio.sleep(watched)
        killed = time.perf_counter()
        await victim.kill()
        await asyncio.sleep(watched)
        for name, viewer in viewers.items():
            await viewer.sees(2)
            cases[name].before.append(viewer.longest(killed - watched, killed))
            cases[name].after.append(viewer.longest(killed, killed + watched))
            cases[name].replaced.append(list(viewer.running.values())[1] - killed)
    return victim


def summary(cases: Mapping[str, Case]) -> dict[str, Any]:
    """Return the figures, times in milliseconds."""
    return {
        name: {
            "before": Percentiles.of(case.before, MILLISECONDS).model_dump(),
            "after": Percentiles.of(case.after, MILLISECONDS).model_dump(),
            "replaced": Percentiles.of(case.replaced, MILLISECONDS).model_dump(),
            "longest_before": round(max(case.before) * MILLISECONDS),
            "longest": round(max(case.after) * MILLISECONDS),
        }
        for name, case in cases.items()
    }


def printed(figures: Mapping[str, Any]) -> str:
    """Return the figures as a table."""
    rows = [
        (
            name,
            f"{told['after']['count']}",
            f"{told['before']['p50']:.0f}",
            f"{told['longest_before']}",
            f"{told['after']['p50']:.0f}",
            f"{told['longest']}",
            f"{told['replaced']['p50']:.0f}",
        )
        for name, told in figures.items()
    ]
    head = (
        "the gateway that is killed; longest gap between two pictures, ms",
        "times",
        *("before, median", "longest"),
        *("after the kill, median", "longest"),
        "new stream, median ms",
    )
    return table(head, rows)


def main() -> None:
    """Measure, or be the body."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.cluster.picture", description=__doc__)
    parser.add_argument("--rounds", type=int, default=10, help="kills (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    parser.add_argument("--be-body", nargs="+", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.be_body:
        uvloop.run(be_body(chosen.be_body[0], chosen.be_body[1:]))
        return

    async def measured(progress: Callable[[str], None]) -> dict[str, Any]:
        return summary(await measure(chosen.rounds, progress))

    measure_and_report("openrois_bench.cluster.picture", measured, printed, chosen.json)


if __name__ == "__main__":
    main()
