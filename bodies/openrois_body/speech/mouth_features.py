"""What a mouth is read from: the spectrum of sound every 10 ms, beside what this voice has had before. Pure.

A frame is 25 ms of sound, in bands between 100 and 7,000 Hz that are as wide as an ear's. Its features say how the
power is spread over the bands, compared with the voice so far, and how loud it is, compared with the loudest sound of
the last moments: none of them changes when all of the sound is louder. They are of five frames, from 80 ms before to
20 ms after the one that is asked for.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["BANDS", "FEATURES", "HOP_MS", "LOOK_AHEAD_MS", "RATES", "Moment", "SoundFeatures", "as_float"]

RATES: Final = (16_000, 48_000)
"""Lowest and highest sample rate that can be read."""
HOP_MS: Final = 10.0
LOOK_AHEAD_MS: Final = 37.5
"""Of sound behind the beginning of a moment that has to be known: 25 ms, and half of a frame."""
BANDS: Final = 18
_OFFSETS: Final = (-8, -4, -2, 0, 2)
"""Frames whose features are used, counted from the one that is asked for."""
FEATURES: Final = len(_OFFSETS) * (BANDS + 1) + 1

_SPAN: Final = 0.025
_LOWEST_HZ, _HIGHEST_HZ = 100.0, 7_000.0
_NOTHING: Final = 1e-10
_RANGE: Final = 50.0
"""dB below the loudest moment that are told apart."""
_QUIETEST: Final = -60.0
"""dB of full scale; a sound that is quieter is none."""
_RELEASE: Final = 0.3
"""dB by which the loudest moment is forgotten, each frame: 30 dB in a second."""
_SLOW_RELEASE: Final = 0.05
_ACTIVE: Final = 25.0
"""dB below the loudest sound of the last seconds in which a frame counts for the voice's mean spectrum."""
_MEMORY_AT_FIRST, _MEMORY = 100, 400
"""Frames that the mean of other voices counts as, and those that the mean of this voice reaches back."""

_NOISE_BLOCK: Final = 400
"""Frames; the noise floor is the lowest level of this block and the one before: of the last 4 to 8 seconds."""
_NOISE_KNOWN: Final = 100
"""Frames after which a noise floor is known."""
_ABOVE_NOISE: Final = 6.0
_SILENT_FRAMES: Final = 8
"""Frames in a row without sound that are a pause; a shorter one may be a stop, as of `t` or `p`."""

Values = NDArray[np.float32]

PRIOR: Final = np.array(
    [
        *(-0.60, -0.58, -0.58, -0.77, -0.98, -1.08, -1.13, -1.13, -1.16),
        *(-1.21, -1.19, -1.10, -1.10, -1.09, -1.17, -1.26, -1.32, -1.33),
    ],
    np.float32,
)
"""How the power of speech is spread over the bands, in 20 dB, before a voice has been heard."""


class Moment(NamedTuple):
    """What is known of 10 ms of sound: its features, and whether it is part of a pause."""

    features: Values
    is_pause: bool


class _Frame(NamedTuple):
    bands: Values
    level: float


class SoundFeatures:
    """Makes features of sound that comes in pieces of any size; the same ones whatever the size.

    Args:
        rate: samples a second, within `RATES`.
    """

    def __init__(self, rate: int) -> None:
        if not RATES[0] <= rate <= RATES[1]:
            raise ValueError(
                f"the rate must be between {RATES[0]} and {RATES[1]} Hz, and is {rate}; resample the sound"
            )
        self._rate = rate
        self._spectrum = _Spectrum(rate)
        size = self._spectrum.size
        self._begin = -size
        """The number of the first sample that is kept; before the first one of all there is silence."""
        self._kept = np.zeros(size, np.float32)
        self._count = 0
        silence = _Frame(np.full(BANDS, 10 * np.log10(_NOTHING), np.float32), -100.0)
        self._frames = deque([silence] * (_OFFSETS[-1] - _OFFSETS[0] + 1), _OFFSETS[-1] - _OFFSETS[0] + 1)
        self._loudest = self._slow_loudest = _QUIETEST
        self._mean, self._weight = PRIOR.copy(), _MEMORY_AT_FIRST
        self._noise = _NoiseFloor()

    def add(self, samples: Values) -> Iterator[Moment]:
        """Add sound, and return the moments that are known now, in order; use all of them."""
        self._kept = np.concatenate((self._kept, samples))
        while True:
            first = round((self._count + 0.5) * self._rate / 100 - self._spectrum.size / 2) - self._begin
            if first + self._spectrum.size > len(self._kept):
                return
            self._kept, self._begin = self._kept[first:], self._begin + first
            self._add_frame(self._kept[: self._spectrum.size])
            self._count += 1
            if self._count > _OFFSETS[-1]:
                yield Moment(self._features(), self._noise.is_pause)

    def _add_frame(self, sound: Values) -> None:
        bands = self._spectrum.bands(sound)
        level = 10 * float(np.log10((10 ** (bands / 10)).sum() + 1e-12))
        self._frames.append(_Frame(bands, level))
        self._loudest = max(level, self._loudest - _RELEASE, _QUIETEST)
        self._slow_loudest = max(level, self._slow_loudest - _SLOW_RELEASE, _QUIETEST)
        self._noise.add(level)
        if level > self._slow_loudest - _ACTIVE:
            self._weight = min(self._weight + 1, _MEMORY)
            self._mean += (_spread(bands, max(level, self._loudest - _RANGE)) - self._mean) / np.float32(self._weight)

    def _features(self) -> Values:
        made = np.empty(FEATURES, np.float32)
        lowest = self._loudest - _RANGE
        for number, offset in enumerate(_OFFSETS):
            frame = self._frames[offset - _OFFSETS[-1] - 1]
            level, first = max(frame.level, lowest), number * (BANDS + 1)
            made[first : first + BANDS] = _spread(frame.bands, level) - self._mean
            made[first + BANDS] = min(0.5, (level - self._loudest) / 20)
        made[-1] = max(-2.5, (self._loudest - self._slow_loudest) / 20)
        return made


class _Spectrum:
    """The power of a frame in each band, in dB of full scale."""

    def __init__(self, rate: int) -> None:
        self.size = round(rate * _SPAN)
        self._window = np.hanning(self.size + 2)[1:-1].astype(np.float32)
        frequencies = np.asarray(np.fft.rfftfreq(self.size, 1 / rate), np.float64)
        frequencies = frequencies[frequencies < _HIGHEST_HZ]
        self._lines = len(frequencies)
        lowest, highest = _mel(np.array([_LOWEST_HZ, _HIGHEST_HZ]))
        places, edges = _mel(frequencies)[:, None], np.linspace(lowest, highest, BANDS + 2)
        rising = (places - edges[:-2]) / (edges[1:-1] - edges[:-2])
        falling = (edges[2:] - places) / (edges[2:] - edges[1:-1])
        scale = float((self._window**2).sum()) * self.size / 2
        self._weights = (np.clip(np.minimum(rising, falling), 0, None) / scale).astype(np.float32)

    def bands(self, sound: Values) -> Values:
        lines = np.fft.rfft(sound * self._window)[: self._lines]
        power = (lines.real**2 + lines.imag**2).astype(np.float32)
        return np.asarray(10 * np.log10(power @ self._weights + np.float32(_NOTHING)), np.float32)


class _NoiseFloor:
    """Detects pauses: frames that are no louder than the quietest of the last seconds."""

    def __init__(self) -> None:
        self._before = self._lowest = float("inf")
        self._count = self._silent = 0

    @property
    def is_pause(self) -> bool:
        return self._silent >= _SILENT_FRAMES

    def add(self, level: float) -> None:
        if self._count and self._count % _NOISE_BLOCK == 0:
            self._before, self._lowest = self._lowest, float("inf")
        self._count += 1
        self._lowest = min(self._lowest, level)
        floor = min(self._lowest, self._before) if self._count > _NOISE_KNOWN else float("-inf")
        self._silent = self._silent + 1 if level < max(floor + _ABOVE_NOISE, _QUIETEST) else 0


def as_float(samples: NDArray[np.int16] | NDArray[np.float32]) -> Values:
    """Return mono samples as floats between -1 and 1; what is no number is silence.

    Raises:
        ValueError: they are not mono, or neither int16 nor float.
    """
    if samples.ndim != 1:
        raise ValueError(f"the samples must have the shape (n,), mono, and have {samples.shape}")
    if samples.dtype == np.int16:
        return samples.astype(np.float32) / np.float32(32_768)
    if not np.issubdtype(samples.dtype, np.floating):
        raise ValueError(f"the samples must be int16 or float32, and are {samples.dtype}")
    return np.asarray(np.clip(np.nan_to_num(samples, nan=0.0), -1, 1), np.float32)


def _spread(bands: Values, level: float) -> Values:
    return np.asarray(np.clip((bands - np.float32(level)) / np.float32(20), -1.5, 0), np.float32)


def _mel(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places on the ear's scale of pitch."""
    return np.asarray(2595 * np.log10(1 + frequency / 700))
