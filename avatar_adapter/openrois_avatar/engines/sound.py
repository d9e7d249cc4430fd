"""The engine's own sound: a soft cue for some reactions and a radio that is near, as a stream of 20 ms blocks."""

from collections.abc import Callable, Mapping
from typing import Final

import numpy as np
import numpy.typing as npt

RATE: Final = 48_000
BLOCK: Final = 960
"""Samples per block: 20 ms."""
PERIOD: Final = BLOCK / RATE
_LEVEL: Final = 0.1
"""Peak of a cue: -20 dBFS."""
_MAX_CUES: Final = 4
_RADIO_LEVEL: Final = 0.05
"""Peak of the radio directly beside it: -26 dBFS."""
_NOTE: Final = 0.6
"""Seconds of a note of its tune."""
_TUNE: Final = (392.0, 523.3, 659.3, 523.3, 440.0, 523.3, 698.5, 523.3)

Samples = npt.NDArray[np.int16]
_Wave = npt.NDArray[np.float64]


class Sound:
    """Mixes cues into blocks of mono sound. Times are seconds on one clock."""

    def __init__(self) -> None:
        self._cues: list[tuple[float, _Wave]] = []
        self._silence: Samples = np.zeros((BLOCK, 1), np.int16)
        self._made: dict[str, _Wave] = {}
        self._radio, self._near = _tune(), 0.0

    def cue(self, reaction: str, time: float) -> None:
        """Start the sound of a reaction at a time; a reaction without one stays silent."""
        make = _CUES.get(reaction)
        if make is None:
            return
        if reaction not in self._made:
            wave = make()
            self._made[reaction] = wave * (_LEVEL / float(np.abs(wave).max()))
        self._cues = [*self._cues, (time, self._made[reaction])][-_MAX_CUES:]

    def hush(self) -> None:
        """End every cue."""
        self._cues = []

    @property
    def is_silent(self) -> bool:
        """Whether the next block is silent as long as no radio is near."""
        return not self._cues and not self._near

    def block(self, time: float, radio: float = 0.0) -> Samples:
        """Return the 20 ms of sound, (BLOCK, 1), that begin at a time; `radio` is its nearness, 0 (not heard) to 1."""
        if self.is_silent and not radio:
            return self._silence
        mixed = self._heard(time, radio)
        for start, wave in self._cues:
            first = round((time - start) * RATE)
            part = wave[max(first, 0) : max(first + BLOCK, 0)]
            offset = max(-first, 0)
            mixed[offset : offset + len(part)] += part[: BLOCK - offset]
        self._cues = [(start, wave) for start, wave in self._cues if start + len(wave) / RATE > time + PERIOD]
        return np.round(np.clip(mixed, -1, 1) * 32767).astype(np.int16)[:, None]

    def _heard(self, time: float, radio: float) -> _Wave:
        """Return the radio's sound in a block; its loudness changes without a step."""
        first = round(time * RATE)
        played = self._radio[np.arange(first, first + BLOCK) % len(self._radio)]
        loudness = np.linspace(self._near, radio, BLOCK) * _RADIO_LEVEL
        self._near = radio
        return np.asarray(played * loudness)


def _axis(seconds: float) -> _Wave:
    return np.arange(int(seconds * RATE)) / RATE


def _chime(*notes: tuple[float, float], seconds: float = 1.0) -> _Wave:
    """Return soft bells: (start in seconds, frequency in Hz)."""
    wave = np.zeros(int(seconds * RATE))
    for start, frequency in notes:
        time = _axis(seconds - start)
        attack = 1 - np.exp(-time / 0.008)
        tone = np.sin(2 * np.pi * frequency * time) + 0.35 * np.sin(2 * np.pi * 2.01 * frequency * time) * np.exp(
            -time / 0.12
        )
        wave[len(wave) - len(time) :] += tone * attack * np.exp(-time / 0.28)
    return _faded(wave)


def _whoosh(seconds: float) -> _Wave:
    """Return the noise of moved air."""
    noise = np.random.default_rng(5).normal(size=int(seconds * RATE))
    soft = np.convolve(noise, np.hanning(160), mode="same")
    return _faded(soft * np.sin(np.pi * _axis(seconds) / seconds) ** 2)


def _claps(*starts: float) -> _Wave:
    random = np.random.default_rng(9)
    wave = np.zeros(int((starts[-1] + 0.2) * RATE))
    for start in starts:
        time = _axis(0.12)
        burst = np.convolve(random.normal(size=len(time)), np.hanning(24), mode="same")
        first = int(start * RATE)
        wave[first : first + len(time)] += burst * (1 - np.exp(-time / 0.001)) * np.exp(-time / 0.018)
    return wave


def _faded(wave: _Wave) -> _Wave:
    """Return the wave with a fade-out of 20 ms, so that nothing clicks."""
    tail = int(0.02 * RATE)
    wave[-tail:] *= np.linspace(1, 0, tail)
    return wave


_CUES: Final[Mapping[str, Callable[[], _Wave]]] = {
    "nod": lambda: _chime((0.0, 523.3), (0.12, 659.3), seconds=0.9),
    "shake_head": lambda: _chime((0.0, 587.3), (0.16, 440.0), seconds=0.9),
    "wave": lambda: _chime((0.0, 659.3), (0.14, 784.0), (0.28, 987.8), seconds=1.2),
    "bow": lambda: _whoosh(1.0),
    "shrug": lambda: _chime((0.0, 493.9), (0.18, 466.2), seconds=0.9),
    "surprise": lambda: _chime((0.0, 784.0), (0.06, 1174.7), seconds=0.8),
    "raise_hand": lambda: _whoosh(0.5),
    # When the hands meet in the reaction of the same name.
    "clap": lambda: _claps(0.78, 1.06, 1.34, 1.62, 1.90),
}


def _tune() -> _Wave:
    """Return the tune of the radio, which repeats: a few soft plucked notes, peak 1."""
    time = np.arange(round(_NOTE * RATE)) / RATE
    # Each note has died away when the next one begins.
    shape = np.minimum(1, time / 0.01) * np.exp(-5 * time) * (1 - time / _NOTE)
    notes = [shape * (np.sin(2 * np.pi * note * time) + 0.3 * np.sin(4 * np.pi * note * time)) for note in _TUNE]
    wave = np.concatenate(notes)
    return np.asarray(wave / np.abs(wave).max())
