"""Timing of speech as sound: the first sample to the ear, `clear` to silence, the told position, and what it costs.

`python -m openrois_bench.spoken.stream`, in the repository; `--quick` for a first look. Application, gateway and
adapter run in one process, so that all moments are of one clock; a measuring viewer hears what comes over WebRTC. The
latency of the sound stream itself, from the moment of a sample to the ear, is told beside: every sound has it.
"""

import argparse
import asyncio
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_media import Media
from openrois_media.client.speaking import Speaking

from openrois.client import Client
from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import median
from openrois_bench.measuring.result import write_result
from openrois_bench.viewing.ear import Ear, listening

BURST: Final = 192_000
"""Bytes that are pushed at once: two seconds of samples at 48 kHz."""

Samples = NDArray[np.int16]


@dataclass(frozen=True)
class Run:
    """One speech, in milliseconds.

    Attributes:
        first: from the push of the first sample to its moment in the body's sound.
        heard: from the push of the first sample to the ear.
        silence: from `clear` to the last loud sample at the ear.
        position: how far the told position was from what was heard.
    """

    first: float
    heard: float
    silence: float
    position: float


def tone(seconds: float) -> Samples:
    """Return a tone."""
    moments = np.arange(round(seconds * 48_000)) / 48_000
    return np.asarray(np.rint(np.sin(2 * np.pi * 500 * moments) * 12_000), np.int16)


async def cleared(speech: Speaking, ear: Ear, seconds: float) -> Run:
    """Push a second of sound, clear it after so many seconds of hearing it."""
    ear.forget_heard()
    begun = time.monotonic()
    await speech.push(tone(0.95))
    await ear.loud_for(seconds)
    clearing = time.monotonic()
    spoken = await speech.clear()
    await ear.silent_for(0.5)
    assert ear.first is not None, "that is what was waited for"
    moment, heard = ear.first
    last, silent = ear.last
    return Run(
        (moment - begun) * 1000,
        (heard - begun) * 1000,
        (silent - clearing) * 1000,
        abs(last - moment - spoken.seconds) * 1000,
    )


async def burst(speech: Speaking) -> float:
    """Return the CPU seconds that two seconds of sound cost all of them, above what goes on without speech."""
    idle_from, idle_cpu = time.monotonic(), time.process_time()
    await asyncio.sleep(2.0)
    idle = (time.process_time() - idle_cpu) / (time.monotonic() - idle_from)
    begun, cpu = time.monotonic(), time.process_time()
    await speech.push(tone(BURST / 2 / 48_000))
    used, took = time.process_time() - cpu, time.monotonic() - begun
    await speech.clear()
    return used - idle * took


async def measure(runs: int) -> dict[str, Any]:
    """All figures."""
    from tests.support.operated import operated_avatar  # a wheel has no tests

    with tempfile.TemporaryDirectory() as folder:
        async with operated_avatar(Path(folder)) as (gateway, _):
            url = gateway.url.replace("http", "ws")
            async with (
                listening(gateway) as ear,
                Client(url) as client,
                Media(client) as media,
                media.speech("avatar") as speech,
            ):
                found = []
                for number in range(runs):
                    found.append(await cleared(speech, ear, 0.2 + 0.3 * number / runs))
                    print(f"{number + 1} of {runs}: {found[-1]}", file=sys.stderr)
                bursts = [await burst(speech) for _ in range(max(3, runs // 4))]
    own = [each.heard - each.first for each in found]
    return {
        "first pushed sample to its moment in the body's sound (ms)": told([each.first for each in found]),
        "latency of the sound stream itself (ms)": told(own),
        "first pushed sample to the ear (ms)": told([each.heard for each in found]),
        "clear to silence at the ear (ms)": told([each.silence for each in found]),
        "told position beside what was heard (ms)": told([each.position for each in found]),
        "CPU of 192 kB pushed at once, both ends and the gateway (ms)": told([1000 * each for each in bursts]),
    }


def told(values: Sequence[float]) -> dict[str, float]:
    """Median, least and most, in whole milliseconds."""
    whole = [round(each) for each in values]
    return {"median": median(whole), "least": min(whole), "most": max(whole), "runs": len(whole)}


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.spoken.stream", description=__doc__)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--quick", action="store_true", help="four runs")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    figures = asyncio.run(measure(4 if chosen.quick else chosen.runs))
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.spoken.stream", conditions(before), summary=figures)


if __name__ == "__main__":
    main()
