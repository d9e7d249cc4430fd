"""`python -m benchmarks.uplink --rounds 3`: from sent to decoded, our receiver and aiortc's in turns."""

import argparse
import asyncio
import json
import os
import statistics
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import stamp
from openrois_streaming.testing.delays import percentile

from benchmarks.uplink.media import MarkerFinder, PictureTrack, SoundTrack, delays, encoded
from benchmarks.uplink.way import RECEIVERS, Receiver, connected

VIDEO: Final = ("video/VP8", "video/H264")
_SETTLING: Final = 2.0
_WATCHED: Final = 5.0
_HEARD: Final = 4.0
"""Seconds that are measured, before and after."""
_RECOVERY: Final = 5.0
"""Seconds from the loss until the delay is measured again."""


def _summed(values: Sequence[float]) -> dict[str, float]:
    milliseconds = [value * 1000 for value in values]
    return {
        "count": len(milliseconds),
        "p50_ms": round(statistics.median(milliseconds), 2),
        "p95_ms": round(percentile(milliseconds, 0.95), 2),
    }


async def pictures(receiver: Receiver, codec: str, prepared: list[bytes]) -> dict[str, Any]:
    """One round of video."""
    track = PictureTrack(prepared)
    seen: list[float] = []

    def look(luma: NDArray[np.uint8]) -> None:
        found = stamp.read(luma)
        if found is not None and found.number in track.sent_at:
            seen.append(time.monotonic() - track.sent_at[found.number])

    async with connected(receiver, codec, track, look):
        await asyncio.sleep(_SETTLING)
        seen.clear()
        before = time.process_time()
        await asyncio.sleep(_WATCHED)
        cpu = time.process_time() - before
        return _summed(seen) | {"fps": round(len(seen) / _WATCHED, 1), "cpu": round(cpu / _WATCHED, 3)}


async def sound(receiver: Receiver, lost: int) -> dict[str, Any]:
    """One round of audio, with `lost` packets in a row that do not arrive, in the middle."""
    track, finder = SoundTrack(), MarkerFinder()

    def hear(samples: NDArray[np.int16]) -> None:
        finder.add(samples, time.monotonic())

    async with connected(receiver, "audio/opus", track, hear) as way:
        await asyncio.sleep(_SETTLING + _HEARD)
        lost_at = time.monotonic()
        way.path.up.lose_next(lost)
        await asyncio.sleep(_RECOVERY + _HEARD)
        # What was sent last has not been heard yet.
        heard = delays(track.markers, finder.heard)
        before = [delay for sent, delay in heard if lost_at - _HEARD <= sent < lost_at - 0.5]
        after = [delay for sent, delay in heard if sent >= lost_at + _RECOVERY]
        result: dict[str, Any] = {"before": _summed(before), "after": _summed(after)}
        if way.ours is not None:
            result["playout_delay_ms"] = round(way.ours.figures.playout_delay * 1000, 2)
            result["concealed_s"] = round(way.ours.figures.concealed, 3)
        return result


async def measure(rounds: int, kinds: Sequence[str], lost: int) -> dict[str, Any]:
    """Take turns, as often as `rounds` says."""
    runs: list[dict[str, Any]] = []
    for kind in kinds:
        prepared = encoded(kind) if kind in VIDEO else []
        for number in range(rounds):
            for receiver in RECEIVERS if number % 2 == 0 else RECEIVERS[::-1]:
                result = await (pictures(receiver, kind, prepared) if prepared else sound(receiver, lost))
                runs.append({"kind": kind, "receiver": receiver, "load": round(os.getloadavg()[0], 2)} | result)
                print(json.dumps(runs[-1]), file=sys.stderr)
    return {"summary": {kind: _compared(kind, runs) for kind in kinds}, "runs": runs}


def _compared(kind: str, runs: Sequence[dict[str, Any]]) -> dict[str, float]:
    def median(receiver: Receiver, *names: str) -> float:
        found = []
        for run in runs:
            if run["kind"] == kind and run["receiver"] == receiver:
                value: Any = run
                for name in names:
                    value = value[name]
                found.append(float(value))
        return statistics.median(found)

    if kind in VIDEO:
        theirs, ours = median("aiortc", "p50_ms"), median("openrois", "p50_ms")
        return {"aiortc_p50_ms": theirs, "openrois_p50_ms": ours, "ratio": round(ours / theirs, 3)}
    figures = {
        f"{receiver}_{when}_p50_ms": median(receiver, when, "p50_ms")
        for receiver in RECEIVERS
        for when in ("before", "after")
    }
    ratios = {
        f"ratio_{when}": round(figures[f"openrois_{when}_p50_ms"] / figures[f"aiortc_{when}_p50_ms"], 3)
        for when in ("before", "after")
    }
    left = {
        f"{receiver}_left_after_loss_ms": round(
            figures[f"{receiver}_after_p50_ms"] - figures[f"{receiver}_before_p50_ms"], 2
        )
        for receiver in RECEIVERS
    }
    return figures | ratios | left


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print the figures as JSON, and write them to a file if one is named."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.uplink", description=__doc__)
    parser.add_argument("--rounds", type=int, default=3, help="rounds of each (default 3)")
    parser.add_argument("--kinds", nargs="+", choices=(*VIDEO, "audio/opus"), default=[*VIDEO, "audio/opus"])
    parser.add_argument("--lost", type=int, default=5, help="packets of sound, 20 ms each, lost in a row (default 5)")
    parser.add_argument("--json", type=Path, help="a file for the figures")
    chosen = parser.parse_args(arguments)
    measured = asyncio.run(measure(chosen.rounds, chosen.kinds, chosen.lost))
    result = {
        "command": " ".join(["python", "-m", "benchmarks.uplink", *(sys.argv[1:] if arguments is None else arguments)]),
        "versions": {name: version(name) for name in ("aiortc", "aioice", "av", "numpy")},
        "cpus": os.cpu_count(),
        **measured,
    }
    text = json.dumps(result, indent=2)
    print(text)
    if chosen.json is not None:
        chosen.json.write_text(text + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
