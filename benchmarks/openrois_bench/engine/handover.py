"""Cost of handing a picture over from a game engine to the adapter: through a ring, a Unix socket, and TCP.

`python -m openrois_bench.engine.handover`, in the repository. An engine in a process of its own, made with the Python
client, sends pictures at a steady pace; what counts is the time from before `send_video` until the adapter has the
picture in memory of its own, as the encoders take it (NV12 is I420 by then). `ring, drawn` is for an engine that draws
into the ring (`draw_video`): its picture lies there already, and nothing is copied on its side. The ways take turns,
and with them what the machine itself takes for the like (`floor`).
"""

import argparse
import asyncio
import json
import os
import sys
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np
import uvloop
from numpy.typing import NDArray
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.client import connect_from_environment
from openrois_avatar.link.messages import Event, Hello, Log, VideoShape
from openrois_avatar.link.protocol import PixelFormat
from openrois_avatar.link.server import LinkServer

from openrois_bench.engine.floor import KINDS, floor
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles, medians
from openrois_bench.measuring.result import write_result

WAYS: Final = {"ring": "unix", "ring, drawn": "unix", "ring, TCP": "tcp", "Unix": "unix", "TCP": "tcp"}
"""What is compared, and the socket of each."""
FLOORS: Final = {"floor of ring": "ring", "floor of Unix": "Unix", "floor of TCP": "TCP"}
"""What no engine and no adapter on this machine would be faster than, by much."""
WARM: Final = 30
"""Pictures at the beginning that are not counted."""
PATIENCE: Final = 20.0


def size(chosen: argparse.Namespace) -> int:
    """Bytes of a picture."""
    return int(chosen.width * chosen.height * (8 if chosen.format == "bgra" else 3) // 2)


def _copy(pixels: NDArray[np.uint8], room: NDArray[np.uint8]) -> None:
    room[:] = pixels


def _leave(_: NDArray[np.uint8]) -> None:
    """Leave the picture that lies there."""


def engine(chosen: argparse.Namespace) -> None:
    """Be the engine: send pictures at the pace, then tell what they cost, and end."""
    shape = VideoShape(chosen.width, chosen.height, chosen.fps, chosen.format)
    pixel_format = PixelFormat[chosen.format.upper()]
    stride = chosen.width * (4 if pixel_format is PixelFormat.BGRA else 1)
    pictures = [np.random.default_rng(seed).integers(0, 256, size(chosen), np.uint8) for seed in range(KINDS)]
    with connect_from_environment(Hello("benchmark", "1", shape, ring=chosen.engine.startswith("ring"))) as link:
        start, cpu = time.monotonic(), 0.0
        for number in range(WARM + chosen.frames):
            if number == WARM:
                cpu = time.process_time()
            link.poll_commands(max(0.0, start + number / chosen.fps - time.monotonic()))
            pixels = pictures[number % KINDS]
            now = time.monotonic_ns()
            if chosen.engine != "ring, drawn":
                link.send_video(pixels, chosen.width, chosen.height, stride, pixel_format, now)
            elif number < WARM:
                # More pictures than the ring has slots: each holds one when the counting begins.
                link.draw_video(partial(_copy, pixels), chosen.width, chosen.height, pixel_format, now)
            else:
                link.draw_video(_leave, chosen.width, chosen.height, pixel_format, now)
        link.poll_commands(0.1)
        link.send_event(Log(json.dumps({"cpu": time.process_time() - cpu, "dropped": link.dropped_video})))
        link.poll_commands(0.1)


async def handed_over(chosen: argparse.Namespace, way: str) -> dict[str, Any]:
    """One run of one way."""
    said: asyncio.Future[dict[str, Any]] = asyncio.get_running_loop().create_future()
    delays: list[float] = []
    cpu = {"start": 0.0}

    def told(event: Event) -> None:
        if isinstance(event, Log) and not said.done():
            said.set_result(json.loads(event.text))

    async def read(server: LinkServer) -> None:
        async with server.video.open() as pictures:
            async for picture in pictures:
                now = time.monotonic()
                if picture.sequence >= WARM:
                    delays.append(now - picture.captured_at)
                else:
                    cpu["start"] = time.process_time()

    address = "tcp:127.0.0.1:0" if WAYS[way] == "tcp" else None
    async with LinkServer.listen(address, on_event=told) as server:
        reading = asyncio.create_task(read(server))
        environment = {**os.environ, ADDRESS_VARIABLE: server.address, SECRET_VARIABLE: server.secret}
        arguments = ["--engine", way, "--frames", chosen.frames, "--fps", chosen.fps]
        arguments += ["--width", chosen.width, "--height", chosen.height, "--format", chosen.format]
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-m", "openrois_bench.engine.handover", *map(str, arguments), env=environment
        )
        try:
            async with asyncio.timeout(PATIENCE + chosen.frames / chosen.fps):
                spent = await said
            adapter = time.process_time() - cpu["start"]
        finally:
            reading.cancel()
            await asyncio.wait({reading})
            if process.returncode is None:
                process.terminate()
            await process.wait()
        found = Percentiles.of(delays, MILLISECONDS)
        return {
            "way": way,
            "pictures": len(delays),
            "missing": chosen.frames - len(delays),
            "p50_ms": found.p50,
            "p95_ms": found.p95,
            "engine_cpu_ms": 1000 * spent["cpu"] / chosen.frames,
            "adapter_cpu_ms": 1000 * adapter / chosen.frames,
            "load": load(),
        }


async def measure(chosen: argparse.Namespace) -> list[dict[str, Any]]:
    """All rounds, each with every way in turn."""
    runs = []
    for number in range(chosen.rounds):
        for way in chosen.ways:
            if way in FLOORS:
                run = floor(FLOORS[way], size(chosen), chosen.frames, WARM, chosen.fps) | {"load": load()}
            else:
                run = await handed_over(chosen, way)
            runs.append({"round": number, **run})
            print(f"round {number}, {way}: {runs[-1]['p50_ms']:.2f} ms", file=sys.stderr)
    return runs


def summary(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The medians of each way over its rounds, and how many pictures were missing in all of them."""
    rows = medians(runs, by=("way",), of=("p50_ms", "p95_ms", "engine_cpu_ms", "adapter_cpu_ms", "load"))
    return [{**row, "missing": sum(run["missing"] for run in runs if run["way"] == row["way"])} for row in rows]


def main() -> None:
    """Measure, and print and write what was found."""
    parser = argparse.ArgumentParser(prog="openrois_bench.engine.handover")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frames", type=int, default=300, help="that are counted in each run (%(default)s)")
    parser.add_argument("--fps", type=float, default=60)
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=720)
    parser.add_argument("--format", choices=("bgra", "i420", "nv12"), default="nv12")
    parser.add_argument("--ways", nargs="*", choices=(*WAYS, *FLOORS), default=[*WAYS, *FLOORS])
    parser.add_argument("--json", type=Path, help="where the results go")
    parser.add_argument("--engine", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.engine:
        engine(chosen)
        return
    load_before = load()
    runs = uvloop.run(measure(chosen))
    met = conditions(load_before)
    picture = f"{chosen.width}x{chosen.height} {chosen.format} at {chosen.fps:g} pictures a second"
    print(f"{picture}\n{met}\n")
    print("| way | p50 ms | p95 ms | engine CPU ms | adapter CPU ms | load | runs | missing |")
    print("|---" * 8 + "|")
    rows = summary(runs)
    for each in rows:
        print(
            "|", " | ".join(f"{value:.3f}" if isinstance(value, float) else str(value) for value in each.values()), "|"
        )
    write_result(chosen.json, "openrois_bench.engine.handover", met, picture=picture, summary=rows)


if __name__ == "__main__":
    main()
