"""`python -m openrois_bench.streams.uplink --rounds 3`: from sent to decoded, our receiver and aiortc's in turns."""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import stamp

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles, medians
from openrois_bench.measuring.result import write_result
from openrois_bench.streams.uplink.connection import RECEIVERS, Receiver, connected
from openrois_bench.streams.uplink.media import MarkerFinder, PictureTrack, SoundTrack, delays, encoded

VIDEO: Final = ("video/VP8", "video/H264")
_SETTLING: Final = 2.0
_WATCHED: Final = 5.0
_HEARD: Final = 4.0
"""Seconds that are measured, before and after."""
_RECOVERY: Final = 5.0
"""Seconds from the loss until the delay is measured again."""


def _told(seconds: Sequence[float], when: str = "") -> dict[str, float]:
    found = Percentiles.of(seconds, MILLISECONDS)
    return {f"{when}p50_ms": found.p50, f"{when}p95_ms": found.p95}


async def pictures(receiver: Receiver, codec: str, prepared: list[bytes]) -> dict[str, Any]:
    """One round of video."""
    track = PictureTrack(prepared)
    seen: list[float] = []

    def on_picture(luma: NDArray[np.uint8]) -> None:
        found = stamp.read(luma)
        if found is not None and found.number in track.sent_at:
            seen.append(time.monotonic() - track.sent_at[found.number])

    async with connected(receiver, codec, track, on_picture):
        await asyncio.sleep(_SETTLING)
        seen.clear()
        before = time.process_time()
        await asyncio.sleep(_WATCHED)
        cpu = time.process_time() - before
        return _told(seen) | {"fps": round(len(seen) / _WATCHED, 1), "cpu": round(cpu / _WATCHED, 3)}


async def sound(receiver: Receiver, lost: int) -> dict[str, Any]:
    """One round of audio, with `lost` packets in a row that do not arrive, in the middle."""
    track, finder = SoundTrack(), MarkerFinder()

    def on_block(samples: NDArray[np.int16]) -> None:
        finder.add(samples, time.monotonic())

    async with connected(receiver, "audio/opus", track, on_block) as path:
        await asyncio.sleep(_SETTLING + _HEARD)
        lost_at = time.monotonic()
        path.up.lose_next(lost)
        await asyncio.sleep(_RECOVERY + _HEARD)
        # What was sent last has not been heard yet.
        heard = delays(track.markers, finder.heard)
        before = [delay for sent, delay in heard if lost_at - _HEARD <= sent < lost_at - 0.5]
        after = [delay for sent, delay in heard if sent >= lost_at + _RECOVERY]
        return _told(before, "before_") | _told(after, "after_")


async def measure(rounds: int, kinds: Sequence[str], lost: int) -> list[dict[str, Any]]:
    """Take turns, as often as `rounds` says; the medians of each kind and receiver."""
    rows: list[dict[str, Any]] = []
    for kind in kinds:
        prepared = encoded(kind) if kind in VIDEO else []
        runs: list[dict[str, Any]] = []
        for number in range(rounds):
            for receiver in RECEIVERS if number % 2 == 0 else RECEIVERS[::-1]:
                result = await (pictures(receiver, kind, prepared) if prepared else sound(receiver, lost))
                runs.append({"kind": kind, "receiver": receiver, "load": load()} | result)
                print(json.dumps(runs[-1]), file=sys.stderr)
        rows += medians(runs, by=("kind", "receiver"), of=[*result, "load"])
    return rows


def main() -> None:
    """Measure, print the medians as JSON, and write them to a file if one is named."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.streams.uplink", description=__doc__)
    parser.add_argument("--rounds", type=int, default=3, help="rounds of each (default 3)")
    parser.add_argument("--kinds", nargs="+", choices=(*VIDEO, "audio/opus"), default=[*VIDEO, "audio/opus"])
    parser.add_argument("--lost", type=int, default=5, help="packets of sound, 20 ms each, lost in a row (default 5)")
    parser.add_argument("--json", type=Path, help="where the medians go")
    chosen = parser.parse_args()
    before = load()
    rows = asyncio.run(measure(chosen.rounds, chosen.kinds, chosen.lost))
    print(json.dumps(rows, indent=1))
    write_result(chosen.json, "openrois_bench.streams.uplink", conditions(before), summary=rows)


if __name__ == "__main__":
    main()
