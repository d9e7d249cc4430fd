"""The bearing of a sound, by the times at which it reaches two microphones (GCC-PHAT). Pure.

Two microphones on a line show a bearing and nothing else: not how far away the source is, nor whether it is in front or
behind, above or below. So a source is taken to be in front, at their height.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

__all__ = ["WINDOW", "BearingFinder", "is_stereo"]

WINDOW: Final = 4096
"""Samples of one analysis window: 85 ms."""
SOUND_SPEED: Final = 343.0
"""Metres a second, in air of 20 degrees."""
CLEAR: Final = 0.3
"""Share of the sound that must agree on one delay; independent noise in each channel has 0.1 at most."""
_FINER: Final = 8
_LOWEST, _HIGHEST = 200.0, 8000.0
"""Hz: below, both microphones hear the same; above, a codec does not keep phases."""
_FAINT: Final = 1e-4
"""Of the strongest frequency's power: what is fainter says nothing about the direction."""
_SAME: Final = 1e-5
"""The power of the difference of two channels, of that of their sum, up to which they are one: -50 dB."""


def is_stereo(samples: NDArray[np.int16]) -> bool:
    """Return whether two channels, of shape (n, 2), differ."""
    left, right = samples.astype(np.float64).T
    difference, both = left - right, left + right
    return float(difference @ difference) > _SAME * float(both @ both)


class BearingFinder:
    """Finds the bearing of the loudest source.

    Args:
        distance: metres between the two microphones.
    """

    def __init__(self, distance: float) -> None:
        self._longest = distance / SOUND_SPEED * SAMPLE_RATE
        """Samples that a sound from the side takes from one microphone to the other."""
        frequencies = np.fft.rfftfreq(2 * WINDOW, 1 / SAMPLE_RATE)
        self._heard = (frequencies >= _LOWEST) & (frequencies <= _HIGHEST)

    def find(self, samples: NDArray[np.int16]) -> float | None:
        """Return the bearing of the loudest source in `samples`, of shape (`WINDOW`, 2).

        Returns radians from straight ahead, positive to the right; None if the channels do not agree on a direction.
        """
        spectra = np.fft.rfft(samples * np.hanning(WINDOW)[:, None], 2 * WINDOW, axis=0)
        cross = spectra[:, 0] * np.conj(spectra[:, 1])
        power = np.abs(cross)
        used = self._heard & (power > _FAINT * power[self._heard].max(initial=0.0))
        if not used.any():
            return None
        phases = np.where(used, cross / np.where(used, power, 1.0), 0)
        size = 2 * WINDOW * _FINER
        agreement = np.fft.irfft(phases, size) * (size / (2 * np.count_nonzero(used)))
        reach = math.ceil(self._longest * _FINER) + 1
        near = np.concatenate((agreement[-reach:], agreement[: reach + 1]))
        best = int(near.argmax())
        if near[best] < CLEAR:
            return None
        # The left channel is late by this much: the source is on the right.
        delay = (best - reach) / _FINER
        return math.asin(max(-1.0, min(1.0, delay / self._longest)))
