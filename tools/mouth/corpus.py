"""Sound with the label of every 10 ms: the fitted sentences in several voices, as they are and changed."""

import asyncio
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.messages import Viseme
from openrois_body.speech.mouth import LABELS
from openrois_body.speech.mouth_features import FEATURES, HOP_MS, SoundFeatures
from openrois_body.speech.synthesizer import Synthesizer

from tests.support.mouth import Spoken, spoken_by_espeak, spoken_by_flite
from tests.support.mouth_sentences import FITTED

__all__ = ["labelled", "sentences"]

ESPEAK: Final = (None, "m1", "m2", "m4", "m7", "f1", "f3", "f4", "Andy", "Alicia", "klatt2", "steph")
"""Voices of espeak; the first one says all sentences, each of the others a third of them."""
RATES: Final = (175, 140, 220)
"""Words a minute."""
FLITE: Final = ("slt", "awb")
CHANGED: Final = {"espeak": 1, "flite": 5}
"""How often each sentence is added once more, changed: flite has few voices, and they are more like persons."""

_SAMPLE_RATES: Final = (16_000, 24_000, 48_000)
_TOP_HZ: Final = 8_000

Sound = NDArray[np.float32]


def sentences() -> list[tuple[Spoken, int]]:
    """Return each sentence, and how often it is changed."""
    espeak = [(spoken, CHANGED["espeak"]) for spoken in asyncio.run(_espeak())]
    flite = [(spoken_by_flite(each, voice), CHANGED["flite"]) for voice in FLITE for each in FITTED["en"]]
    return [*espeak, *flite]


def labelled(
    spoken: Spoken, changes: int, chance: np.random.Generator
) -> Iterator[tuple[NDArray[np.float32], list[int]]]:
    """Return the features and labels of a sentence as it is, and changed so many times."""
    sound = (spoken.samples / 32_768).astype(np.float32)
    yield _features(sound, spoken.rate, spoken.visemes, 1.0)
    for _ in range(changes):
        rate, faster = int(chance.choice(_SAMPLE_RATES)), float(chance.uniform(0.9, 1.12))
        yield _features(_changed(sound, spoken.rate, rate, faster, chance), rate, spoken.visemes, faster)


async def _espeak() -> list[Spoken]:
    async with Synthesizer() as synthesizer:
        return [
            await spoken_by_espeak(synthesizer, sentence, language, voice, RATES[(number + place) % len(RATES)])
            for language, said in FITTED.items()
            for number, voice in enumerate(ESPEAK)
            for place, sentence in enumerate(said)
            if number == 0 or place % 3 == number % 3
        ]


def _features(
    sound: Sound, rate: int, visemes: Sequence[Viseme], faster: float
) -> tuple[NDArray[np.float32], list[int]]:
    moments = list(SoundFeatures(rate).add(sound))
    times = (np.arange(len(moments)) + 0.5) * HOP_MS * faster
    places = np.searchsorted([each.offset_ms for each in visemes], times, side="right")
    labels = [_label("sil", 1.0), *(_label(each.shape, each.weight) for each in visemes)]
    made = np.array([moment.features for moment in moments], np.float32).reshape(-1, FEATURES)
    return made, [labels[place] for place in places]


def _label(shape: str, weight: float) -> int:
    weak = LABELS[-1]
    if shape == weak.name and weight < 0.5:
        return len(LABELS) - 1
    return [label.name for label in LABELS].index(shape)


def _changed(sound: Sound, rate: int, target: int, faster: float, chance: np.random.Generator) -> Sound:
    """Return the sound at another sample rate, faster and higher, by another throat, unsteadily loud, in noise."""
    lines = np.fft.rfft(sound)
    frequencies = np.linspace(0, rate / 2, len(lines))
    knots = np.geomspace(100, _TOP_HZ, 5)
    tilt = np.linspace(-1, 1, 5) * chance.uniform(-6, 6)
    lines = lines * 10 ** (np.interp(frequencies, knots, chance.normal(0, 2.5, 5) + tilt) / 20)
    size = round(len(sound) / rate * target / faster)
    kept = np.zeros(size // 2 + 1, complex)
    count = min(len(kept), len(lines))
    kept[:count] = lines[:count]
    made = np.fft.irfft(kept, size) * size / len(sound)
    steps = max(2, round(size / target / chance.uniform(0.12, 0.3)))
    made *= 10 ** (np.interp(np.arange(size), np.linspace(0, size, steps), chance.uniform(-8, 8, steps)) / 20)
    made *= chance.uniform(0.1, 1.0) / max(1e-6, float(np.abs(made).max()))
    if chance.random() < 0.6:
        loud = float(np.sqrt(np.mean(made**2)))
        noise = np.convolve(chance.normal(0, 1, size), (1, chance.uniform(0, 1)), "same")
        made += noise * loud / 10 ** (chance.uniform(15, 55) / 20)
    return made.astype(np.float32)
