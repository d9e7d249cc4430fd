"""The camera of the simulated robot: pictures a second at a viewer, and processor time of a picture.

`python -m openrois_bench.streams.robot`, in the repository. A gateway and the robot run as they do for users, and the
robot is watched by nothing, by a viewer while it stands, and by a viewer while it drives from room to room. Beside what
the adapter takes in all (drawing, encoding, sending) stands what drawing alone takes.
"""

import argparse
import asyncio
import json
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import cv2
from openrois_body.messages import Place
from openrois_robots.simulated.camera import SIZE
from openrois_robots.simulated.drawing.renderer import Renderer
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.world.plan import APARTMENT

from openrois.client import Client
from openrois.client.components import Navigation
from openrois.errors import Aborted
from openrois_bench.errors import within
from openrois_bench.measuring.conditions import load
from openrois_bench.processes.child import Child, child
from openrois_bench.viewing.application import Playing, application

_START_TIMEOUT: Final = 30.0
_SETTLE: Final = 3.0
"""Seconds after the start, and after the first picture, that are not measured."""
_CAMERA: Final = "robot/video_streaming"
_ROUND: Final = ("2.5,1.0", "1.2,-0.9", "-1.6,-1.6", "-1.5,2.6")


@dataclass(frozen=True, slots=True)
class Watched:
    """What was measured in one situation.

    Attributes:
        situation: which.
        fps: pictures a second at the viewer.
        longest_gap: milliseconds between two of them at most.
        cores: processors that the adapter used.
        cpu: milliseconds of processor time for each picture.
    """

    situation: str
    fps: float
    longest_gap: float
    cores: float
    cpu: float


async def unwatched(robot: Child, seconds: float) -> Watched:
    """Measure the adapter without a viewer."""
    await asyncio.sleep(_SETTLE)
    before, began = robot.cpu(), time.monotonic()
    await asyncio.sleep(seconds)
    return Watched("nothing watches", 0.0, 0.0, (robot.cpu() - before) / (time.monotonic() - began), 0.0)


async def watched(robot: Child, playing: Playing, situation: str, seconds: float) -> Watched:
    """Measure the adapter with a viewer, which decodes what it gets."""
    ends = time.monotonic() + _SETTLE
    while time.monotonic() < ends:
        await playing.picture()
    before, began = robot.cpu(), time.monotonic()
    arrivals = [(await playing.picture()).at]
    while time.monotonic() < began + seconds:
        arrivals.append((await playing.picture()).at)
    passed, used = time.monotonic() - began, robot.cpu() - before
    gaps = [later - earlier for earlier, later in pairwise(arrivals)]
    count = len(arrivals) - 1
    return Watched(situation, count / passed, 1000 * max(gaps), used / passed, 1000 * used / count)


def drawn(pictures: int) -> float:
    """Return the milliseconds of processor time that drawing one picture takes, on a way through all rooms."""
    cv2.setNumThreads(1)
    renderer = Renderer(APARTMENT, *SIZE)
    places = [Place(-4 + 8 * number / pictures, -1.3, 20.0 * number / pictures) for number in range(pictures)]
    renderer.draw(View(places[0]))
    before = time.process_time()
    for place in places:
        renderer.draw(View(place, -0.1))
    used = time.process_time() - before
    renderer.close()
    return 1000 * used / pictures


@asynccontextmanager
async def _driving(url: str) -> AsyncIterator[None]:
    """Let the robot drive from room to room for as long as the block runs."""
    async with Client(url) as client:
        navigation = await client.find(Navigation)

        async def go_round() -> None:
            while True:
                # Where a busy machine stands still, the dead man's switch stops the robot.
                with suppress(Aborted):
                    await client.run(navigation.start())

        async with navigation.bound():
            await navigation.set(target_positions=list(_ROUND))
            going = asyncio.create_task(go_round(), name="driving")
            try:
                yield
            finally:
                going.cancel()
                await asyncio.wait({going})


async def measured(seconds: float) -> list[Watched]:
    """Measure all situations.

    Raises:
        BenchFailed: a process does not start, or no picture comes.
    """
    async with child("-m", "openrois.cli", "gateway", "--port", "0") as gateway:
        url = f"ws://{urlsplit(gateway.said.removeprefix('listening ').strip()).netloc}/"
        async with child("-m", "openrois.cli", "robot", "simulated", "--gateway", f"{url}adapter") as robot:
            async with within(_START_TIMEOUT, "the start of the robot"), Client(url) as client:
                while _CAMERA not in await client.search():  # noqa: ASYNC110 - as it is for every adapter
                    await asyncio.sleep(0.1)
            found = [await unwatched(robot, seconds)]
            async with application(url) as viewer, viewer.playing(_CAMERA, "video/H264") as playing:
                found.append(await watched(robot, playing, "a viewer, the robot stands", seconds))
                async with _driving(url):
                    found.append(await watched(robot, playing, "a viewer, the robot drives", seconds))
            return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure, and print a line for each situation."""
    parser = argparse.ArgumentParser(
        prog="python -m openrois_bench.streams.robot", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--seconds", type=float, default=20.0, help="of each situation (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args(arguments)
    found = asyncio.run(measured(chosen.seconds))
    drawing = drawn(600)
    for each in found:
        print(
            f"{each.situation:<28} {each.fps:5.1f} pictures/s, longest gap {each.longest_gap:4.0f} ms,"
            f" {each.cores:.4f} of a core, {each.cpu:.2f} ms a picture"
        )
    print(f"{'drawing alone':<28} {drawing:.2f} ms a picture")
    if chosen.json is not None:
        told = {"situations": [asdict(each) for each in found], "drawing_ms": drawing, "load": load()}
        chosen.json.write_text(json.dumps(told, indent=1) + "\n")


if __name__ == "__main__":
    main()
