"""The mouth that is read from sound: how often it is as far open as by the phonemes, and what it costs.

`python -m openrois_bench.spoken.mouth`, in the repository; Debian's package `flite` speaks beside espeak. The sentences
are those that nothing was fitted to. Compared are moments from the first phoneme to the last, one every 10 ms, in three
classes: closed, half open, open. Figures are of synthetic voices; of persons the phonemes are not known.
"""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.messages import Viseme
from openrois_body.speech.mouth import SoundMouth
from openrois_body.speech.synthesizer import Synthesizer

from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result

if TYPE_CHECKING:
    from tests.support.mouth import Spoken

ESPEAK: Final = (None, "m3", "m6", "f2", "f5", "Annie", "Mike", "klatt4", "linda")
"""Voices of espeak that nothing was fitted to, beside the language's own."""
FLITE: Final = {"slt": "fitted", "awb": "fitted", "rms": "unknown"}
GAINS: Final = (-20, 12)
"""Decibels."""
RATIOS: Final = (30, 20, 10)
"""Decibels by which white noise is lower than the speech."""
PIECE: Final = 960
SECONDS: Final = 60

Counts = NDArray[np.int64]


async def sentences(voices: Sequence[str | None]) -> dict[str, list["Spoken"]]:
    """Return what is judged: all sentences of a language in each of the voices."""
    from tests.support.mouth import spoken_by_espeak, spoken_by_flite  # a wheel has no tests
    from tests.support.mouth_sentences import JUDGED

    async with Synthesizer() as synthesizer:
        said = {
            f"espeak, {language}": [
                await spoken_by_espeak(synthesizer, sentence, language, voice) for voice in voices for sentence in each
            ]
            for language, each in JUDGED.items()
        }
    for voice, known in FLITE.items():
        said[f"flite, {voice} ({known})"] = [spoken_by_flite(sentence, voice) for sentence in JUDGED["en"]]
    return said


def judged(said: Iterable["Spoken"], shapes: Callable[["Spoken"], Iterable[Viseme]]) -> Counts:
    """Return how often each opening by the phonemes (rows) was each one that was read (columns)."""
    from tests.support.mouth import confusion  # a wheel has no tests

    return np.asarray(np.sum([confusion(spoken, shapes(spoken)) for spoken in said], axis=0))


def by_loudness(said: Sequence["Spoken"]) -> float:
    """Return the share that loudness alone gets right, with the two limits that are best for these very sentences."""
    from tests.support.mouth import openings, speaking_times  # a wheel has no tests

    levels, expected = [], []
    for spoken in said:
        times = speaking_times(spoken)
        size = spoken.rate // 40
        padded = np.pad(spoken.samples.astype(np.float64), size)
        starts = np.rint(times * spoken.rate / 1000 + size / 2).astype(int)
        power = np.array([np.mean(padded[start : start + size] ** 2) for start in starts]) + 1
        levels.append(10 * np.log10(power / power.max()))
        expected.append(openings(spoken.visemes, times))
    level, right = np.concatenate(levels), np.concatenate(expected)
    limits = np.arange(-50, 0, 1.0)
    return max(
        float(np.mean((level > low).astype(int) + (level > high) == right))
        for low in limits
        for high in limits
        if high >= low
    )


def told(counts: Counts) -> dict[str, object]:
    """Return a table of counts as shares of the time."""
    shares = (counts / counts.sum()).round(3)
    return {
        "agreement": round(float(np.trace(counts) / counts.sum()), 3),
        "most frequent class": round(float(counts.sum(axis=1).max() / counts.sum()), 3),
        "closed, half open, open (rows: by phonemes)": shares.tolist(),
    }


def with_gain(said: Sequence["Spoken"], decibels: float) -> float:
    """Return the share of the time in which the opening is another one when all is louder or quieter."""
    from tests.support.mouth import openings, read_mouth, speaking_times  # a wheel has no tests

    changed = []
    for spoken in said:
        loud = np.clip(spoken.samples * 10 ** (decibels / 20), -32_768, 32_767).astype(np.int16)
        times = speaking_times(spoken)
        before, after = (openings(read_mouth(each, spoken.rate), times) for each in (spoken.samples, loud))
        changed.append(before != after)
    return round(float(np.mean(np.concatenate(changed))), 4)


def in_noise(said: Sequence["Spoken"], ratio: float) -> float:
    """Return the agreement in white noise that is so many decibels lower than the speech, and a second ahead of it."""
    from tests.support.mouth import agreement, read_mouth  # a wheel has no tests

    def shapes(spoken: "Spoken") -> Iterable[Viseme]:
        sound = np.pad(spoken.samples.astype(np.float64), (spoken.rate, 0))
        loud = float(np.sqrt(np.mean(spoken.samples.astype(np.float64) ** 2)))
        sound += np.random.default_rng(len(sound)).normal(0, loud / 10 ** (ratio / 20), len(sound))
        noisy = np.clip(sound, -32_768, 32_767).astype(np.int16)
        return [Viseme(each.offset_ms - 1000, each.shape, each.weight) for each in read_mouth(noisy, spoken.rate)]

    return round(agreement(judged(said, shapes)), 3)


def cost(said: Sequence["Spoken"]) -> dict[str, float]:
    """Return the CPU that a minute of speech at 48 kHz takes in pieces of 20 ms, and how far shapes stay behind."""
    sound = np.resize(np.concatenate([spoken.samples for spoken in said]), SECONDS * 48_000)
    mouth, behind, changes, shown = SoundMouth(), 0.0, 0, "sil"
    begin = time.process_time()
    for first in range(0, len(sound), PIECE):
        shapes = mouth.push(sound[first : first + PIECE])
        behind = max(behind, (first + PIECE) / 48 - shapes.until_ms)
        for viseme in shapes.visemes:
            changes, shown = changes + (viseme.shape != shown), viseme.shape
    spent = time.process_time() - begin
    return {
        "cores, at real time": round(spent / SECONDS, 4),
        "sound that is not read yet, at most (ms)": behind,
        "changes of the mouth a second": round(changes / SECONDS, 1),
    }


async def measure(voices: Sequence[str | None]) -> dict[str, object]:
    """All figures."""
    from tests.support.mouth import read_mouth  # a wheel has no tests

    said = await sentences(voices)
    figures: dict[str, object] = {}
    for name, spoken in said.items():
        figures[name] = told(judged(spoken, lambda each: read_mouth(each.samples, each.rate)))
        print(f"{name}: done", file=sys.stderr)
    both = [*said["espeak, en"], *said["espeak, de"]]
    some = both[:: len(both) // 50]
    return {
        "agreement": figures,
        "loudness alone, at best": {name: round(by_loudness(spoken), 3) for name, spoken in said.items()},
        "changed by gain": {f"{gain:+} dB": with_gain(some, gain) for gain in GAINS},
        "agreement in noise": {f"{ratio} dB": in_noise(some, ratio) for ratio in RATIOS},
        "cost": cost(both[:50]),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.spoken.mouth", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one voice of espeak in place of nine")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    figures = asyncio.run(measure(ESPEAK[3:4] if chosen.quick else ESPEAK))
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.spoken.mouth", conditions(before), summary=figures)


if __name__ == "__main__":
    main()
