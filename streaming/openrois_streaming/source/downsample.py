"""Downsampling from 48,000 Hz, as of all media, to what listens to speech, in one channel. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE

__all__ = ["DOWNSAMPLED_RATES", "SPEECH_RATE", "Downsampler"]

SPEECH_RATE: Final = 16_000
"""Sample rate of speech detection and recognition, in Hz."""
DOWNSAMPLED_RATES: Final = (8_000, 16_000, 24_000, 48_000)
"""Rates to which sound is downsampled, in Hz."""
_REACH: Final = 12
"""Samples to either side that a sample depends on, at the lower rate: 0.75 ms at 16,000 Hz."""
_CUTOFF: Final = 7_300 / SPEECH_RATE
"""As a share of the lower rate."""


class Downsampler:
    """Downsamples a stream of sound in blocks of any length, with a delay of 12 samples of the lower rate.

    Args:
        rate: one of `DOWNSAMPLED_RATES`; at 48,000 the channels become one, and nothing else is done.
    """

    def __init__(self, rate: int = SPEECH_RATE) -> None:
        assert rate in DOWNSAMPLED_RATES, "a rate is checked where it is given"
        self._factor = SAMPLE_RATE // rate
        self._filter = _low_pass(self._factor)
        self._before = np.zeros(len(self._filter) - 1, np.float32)

    def add(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return what can be computed once `samples`, of shape (n, channels), is known; mono, of shape (m,)."""
        joined = np.concatenate((self._before, samples.mean(axis=1, dtype=np.float32)))
        taps = len(self._filter)
        count = max(0, (len(joined) - taps) // self._factor + 1)
        windows = np.lib.stride_tricks.sliding_window_view(joined, taps)[:: self._factor] if count else None
        self._before = joined[count * self._factor :]
        if windows is None:
            return np.zeros(0, np.int16)
        return np.clip(np.rint(windows @ self._filter), -32768, 32767).astype(np.int16)


def _low_pass(factor: int) -> NDArray[np.float32]:
    """Return a windowed sinc: of 48,000 Hz to 16,000, 9 kHz, which would alias to 7 kHz, is 50 dB lower."""
    if factor == 1:
        return np.ones(1, np.float32)
    place = np.arange(-_REACH * factor, _REACH * factor + 1)
    taps = np.sinc(2 * _CUTOFF / factor * place) * np.hamming(len(place))
    return np.asarray(taps / taps.sum(), np.float32)
