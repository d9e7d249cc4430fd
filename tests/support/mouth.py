# ruff: noqa: RUF001 - the letters of IPA are meant
"""Sentences as sound with the mouth shapes of their phonemes, and how far those that are read from the sound agree."""

import re
import shutil
import subprocess
import wave
from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from openrois_body.messages import Viseme
from openrois_body.speech.mouth import Opening, SoundMouth, opening
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech.visemes import CLOSED, Phoneme, visemes

STEP_MS: Final = 10.0
"""Milliseconds from one comparison to the next."""

_NAMES: Final = (
    "aa:ɑː ae:æ ah:ʌ ao:ɔː aw:aʊ ax:ə ay:aɪ b:b ch:tʃ d:d dh:ð eh:ɛ er:ɜː ey:eɪ f:f g:ɡ hh:h ih:ɪ iy:iː jh:dʒ k:k "
    "l:l m:m n:n ng:ŋ ow:oʊ oy:ɔɪ p:p pau: r:ɹ s:s sh:ʃ t:t th:θ uh:ʊ uw:uː v:v w:w y:j z:z zh:ʒ"
)
_ARPABET: Final = dict(pair.split(":") for pair in _NAMES.split())
"""What flite calls a phoneme, in IPA."""


class Spoken(NamedTuple):
    """A sentence as sound, and the mouth shapes of its phonemes."""

    voice: str
    rate: int
    samples: NDArray[np.int16]
    visemes: Sequence[Viseme]

    @property
    def duration_ms(self) -> float:
        return len(self.samples) * 1000 / self.rate


async def spoken_by_espeak(
    synthesizer: Synthesizer, sentence: str, language: str, voice: str | None = None, rate: int = 175
) -> Spoken:
    """Return a sentence in the product's own voice, or a variant of it."""
    speech = await synthesizer.synthesize(sentence, language=language, voice=voice, rate=rate)
    return Spoken(voice or "default", 48_000, speech.samples, speech.visemes)


def spoken_by_flite(sentence: str, voice: str) -> Spoken:
    """Return an English sentence in a voice that has nothing to do with espeak; flite has to be installed."""
    program = shutil.which("flite")
    assert program is not None
    said = subprocess.run(
        [program, "-voice", voice, "-psdur", "-t", sentence, "-o", "/dev/stderr"], capture_output=True, check=True
    )
    with wave.open(BytesIO(said.stderr)) as file:
        rate, samples = file.getframerate(), np.frombuffer(file.readframes(-1), np.int16)
    segments = re.findall(r"(\w+):([\d.]+)", said.stdout.decode())
    begins = [0.0, *(1000 * float(end) for _, end in segments)]
    phonemes = [Phoneme(begin, _ARPABET[name]) for begin, (name, _) in zip(begins, segments, strict=False)]
    return Spoken(f"flite {voice}", rate, samples, visemes(phonemes, len(samples) * 1000 / rate))


def read_mouth(sound: NDArray[np.int16] | NDArray[np.float32], rate: int, piece: int | None = None) -> list[Viseme]:
    """Return the changes of the mouth that are read from a sound in pieces of so many samples, 20 ms unless given."""
    size, mouth, changes = piece or rate // 50, SoundMouth(rate), list[Viseme]()
    pushed = [mouth.push(sound[first : first + size]) for first in range(0, len(sound), size)]
    for shapes in (*pushed, mouth.finish()):
        for viseme in shapes.visemes:
            if not changes or (viseme.shape, viseme.weight) != (changes[-1].shape, changes[-1].weight):
                changes.append(viseme)
    return changes


def openings(shapes: Iterable[Viseme], times_ms: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return how far the mouth is open at each of the times, in order; it is closed before the first shape."""
    known = list(shapes)
    places = np.searchsorted([each.offset_ms for each in known], times_ms, side="right")
    return np.array([Opening.CLOSED, *(opening(each.shape, each.weight) for each in known)])[places]


def speaking_times(spoken: Spoken) -> NDArray[np.float64]:
    """Return the times that are compared: from the first phoneme to the last, with the pauses between them."""
    shapes = spoken.visemes
    begin = next((each.offset_ms for each in shapes if each.shape != CLOSED), 0.0)
    end = shapes[-1].offset_ms if shapes[-1].shape == CLOSED else spoken.duration_ms
    times = np.arange(STEP_MS / 2, spoken.duration_ms, STEP_MS)
    return np.asarray(times[(times >= begin) & (times < end)], np.float64)


def confusion(spoken: Spoken, shapes: Iterable[Viseme]) -> NDArray[np.int64]:
    """Return how often each opening by the phonemes (rows) was each opening in `shapes` (columns)."""
    times = speaking_times(spoken)
    counts = np.zeros((3, 3), np.int64)
    np.add.at(counts, (openings(spoken.visemes, times), openings(shapes, times)), 1)
    return counts


def agreement(counts: NDArray[np.int64]) -> float:
    """Return the share of the time in which both agree, of a table that `confusion` made."""
    return float(np.trace(counts) / counts.sum())
