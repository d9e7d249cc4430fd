"""Features of a moment of sound: loudness, pitch, and the shape of the spectrum. Pure."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.downsample import SPEECH_RATE

from openrois_body.hearing.noise_floor import LOWEST

__all__ = ["HOP", "SPAN", "Moment", "measure"]

HOP: Final = 160
"""Samples from one moment to the next: 10 ms."""
SPAN: Final = 640
"""Samples of a moment: 40 ms, more than two periods of the lowest voice."""
_SIZE: Final = 2048
_BANDS_HZ: Final = (100, 300, 500, 700, 1000, 1400, 2000, 2800, 3800, 5000, 7000)
_SHORTEST, _LONGEST = SPEECH_RATE // 400, SPEECH_RATE // 70
"""Periods of voices, in samples."""
_PERIODIC: Final = 0.5
"""Agreement of a sound with itself one period later; of noise it is less."""
_ABOUT_THE_BEST: Final = 0.9
_LOBE: Final = 6
"""Frequencies to either side over which the window spreads one."""
_PURE: Final = 0.9
_TINY: Final = 1e-9

_WINDOW: Final = np.hanning(SPAN).astype(np.float32)
_WINDOW_POWER: Final = float((_WINDOW**2).sum()) * _SIZE / 2
_LIMITS: Final = np.searchsorted(np.fft.rfftfreq(_SIZE, 1 / SPEECH_RATE), _BANDS_HZ)
_OF_WINDOW: Final = np.fft.irfft(np.abs(np.fft.rfft(_WINDOW, _SIZE)) ** 2)
_EXPECTED: Final = (_OF_WINDOW / _OF_WINDOW[0])[_SHORTEST - 1 : _LONGEST + 2]
"""The decrease of the agreement with the delay, as less and less of the window overlaps."""


class Moment(NamedTuple):
    """40 ms of sound.

    `level` is in dB of full scale between 100 and 7000 Hz, `pitch` in octaves above 1 Hz or None where there is none,
    `shape` in dB: how the power is spread over ten bands. `pure`: nearly all of it is at one frequency.
    """

    level: float
    pitch: float | None
    shape: NDArray[np.float64]
    pure: bool


def measure(samples: NDArray[np.int16]) -> Moment:
    """Measure `SPAN` samples."""
    values = samples.astype(np.float32) / 32768
    power = np.abs(np.fft.rfft((values - values.mean()) * _WINDOW, _SIZE)) ** 2
    bands = np.add.reduceat(power, _LIMITS)[:-1]
    whole = float(bands.sum())
    level = 10 * float(np.log10(whole / _WINDOW_POWER + _TINY))
    # A band with less than a thousandth of the power is empty: what is in it is noise.
    shape = 10 * np.log10(bands / (whole + _TINY) + 1e-3)
    peak = int(power.argmax())
    around = float(power[max(0, peak - _LOBE) : peak + _LOBE + 1].sum())
    pitch = _pitch(power) if level > LOWEST else None
    return Moment(level, pitch, shape, around > _PURE * float(power.sum()))


def _pitch(power: NDArray[np.float32]) -> float | None:
    """Return the pitch by autocorrelation: the shortest delay that is about as good as the best."""
    every = np.fft.irfft(power)
    agreement = every[_SHORTEST - 1 : _LONGEST + 2] / (every[0] + _TINY) / _EXPECTED
    inner = agreement[1:-1]
    peaks = np.flatnonzero((inner >= agreement[:-2]) & (inner >= agreement[2:]) & (inner > _PERIODIC))
    if not len(peaks):
        return None
    good = peaks[inner[peaks] > _ABOUT_THE_BEST * inner[peaks].max()][0]
    before, at, after = (float(value) for value in agreement[good : good + 3])
    bend = before - 2 * at + after
    between = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(np.log2(SPEECH_RATE / (_SHORTEST + good + between)))
