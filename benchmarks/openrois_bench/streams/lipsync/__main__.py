"""Lip sync of sound and pictures at a viewer, over ten minutes.

`python -m openrois_bench.streams.lipsync --json FILE`. A session plays colour bars (1280x720, 30 frames a second,
H.264) and the tone to a viewer in another process, which compares each marker of the sound with the picture of the same
moment. There are two errors: `told` is that of a player that brings both together by the sender's reports, as browsers
do; `played` that of a viewer that does not, shows each picture when it is decoded, and plays sound behind its buffer.

With `--scene engine` both come from a game engine on the engine link. With `--scene puppet` or `panda3d` the avatar
speaks; `mouth` is by how much its voice is later than its mouth in the pictures, for a player that goes by the reports.
`--lips sound` has the mouth read from the sound, as of speech that comes without mouth shapes.
"""

import argparse
import asyncio
import itertools
import sys
from pathlib import Path
from typing import Any

import uvloop
from openrois_signaling.messages import Answer, Downward, Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.session.session import StreamSession

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result
from openrois_bench.processes.partner import SWITCH_INTERVAL, Partner, partner
from openrois_bench.streams.lipsync.scenes import LIPS, SCENES, played

_PATIENCE = 15.0
_SETTLING = 10.0
_QUICK = 0.5


async def measure(scene: str, lips: str, minutes: float) -> list[dict[str, Any]]:
    """The figures after each minute, from the beginning on."""
    clock = SystemClock()
    heard: asyncio.Queue[Downward] = asyncio.Queue()
    ids = itertools.count()
    readings = []
    async with (
        played(scene, lips, clock) as sources,
        partner("openrois_bench.streams.lipsync.viewer") as viewer,
        asyncio.TaskGroup() as tasks,
        StreamSession(
            mint=lambda: f"lipsync/p{next(ids)}", send=heard.put_nowait, on_change=lambda _: None, clock=clock
        ) as session,
    ):
        video = VideoPublisher(sources.video, clock=clock, stamp=True)
        audio = AudioPublisher(sources.audio, clock=clock)
        answering = tasks.create_task(_answer_offers(session, viewer, heard))
        session.connect("video", "lipsync/Video", video, "video", ["H264"])
        session.connect("audio", "lipsync/Audio", audio, "audio")
        await asyncio.sleep(_SETTLING)
        await viewer.ask("restart", {}, within=_PATIENCE)
        left = minutes
        while left > 0:
            await asyncio.sleep(60 * min(left, 1))
            left -= 1
            readings.append(await viewer.ask("read", {}, within=_PATIENCE))
            _print_reading(readings[-1])
        answering.cancel()
    return readings


async def _answer_offers(session: StreamSession, viewer: Partner, heard: asyncio.Queue[Downward]) -> None:
    while True:
        message = await heard.get()
        if isinstance(message, Offer):
            sdp = await viewer.ask("answer", {"sdp": message.sdp}, within=_PATIENCE)
            await session.apply_answer(Answer(peer_id=message.peer_id, generation=message.generation, sdp=sdp))


def _print_reading(reading: dict[str, Any]) -> None:
    mouth = reading["mouth"]
    # A voice is full of what looks like markers.
    for name in () if mouth is not None else ("told", "played"):
        sync = reading[name]
        if sync is not None:
            print(
                f"{name:6} {sync['count']:4} markers: median {1000 * sync['median']:+.1f} ms, p95 either way "
                f"{1000 * sync['p95']:.1f} ms, worst {1000 * sync['worst']:.1f} ms, "
                f"drift {60_000 * sync['drift']:+.3f} ms a minute",
                flush=True,
            )
    if mouth is not None:
        median, p95 = 1000 * mouth["median"], 1000 * mouth["p95"]
        print(f"mouth  {mouth['parts']:4} parts: median {median:+.1f} ms, p95 either way {p95:.1f} ms", flush=True)


def main() -> None:
    """Measure, tell after each minute, and write it down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="where the last reading goes")
    parser.add_argument("--scene", choices=SCENES, default=SCENES[0])
    parser.add_argument("--lips", choices=LIPS, default=LIPS[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--quick", action="store_true", help="half a minute, to see that all works")
    options = parser.parse_args()
    before = load()
    sys.setswitchinterval(SWITCH_INTERVAL)
    readings = uvloop.run(measure(options.scene, options.lips, _QUICK if options.quick else options.minutes))
    write_result(options.json, "openrois_bench.streams.lipsync", conditions(before), summary=readings[-1])


if __name__ == "__main__":
    main()
