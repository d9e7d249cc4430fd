"""Shortening and lengthening of sound by one of its periods, which is inaudible. Pure."""

from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Samples = NDArray[np.int16]
"""Of shape (n, channels), 48 kHz."""

SHORTEST_PERIOD = 120
LONGEST_PERIOD = 480
"""Samples: 2.5 and 10 ms, 400 and 100 Hz."""

# Every 6th sample, 8 kHz, is enough to find a period.
_STEP = 6
_ALIKE = 0.8
# Mean square of inaudible sound: -54 dB.
_QUIET = (32768 * 0.002) ** 2


def shorter(samples: Samples, most: int, *, force: bool = False) -> Samples:
    """Return `samples` without one period of `most` samples at most.

    They stay as they are if they are too short or have no period; in quiet parts, and with `force`, any length counts
    as one.
    """
    period = _period(samples, most, force=force)
    if not period:
        return samples
    head = _faded(samples[:period], samples[period : 2 * period])
    return np.concatenate((head, samples[2 * period :]))


def longer(samples: Samples, most: int) -> Samples:
    """Return `samples` with one period of `most` samples at most repeated; unchanged if there is none."""
    period = _period(samples, most, force=True)
    if not period:
        return samples
    bridge = _faded(samples[period : 2 * period], samples[:period])
    return np.concatenate((samples[:period], bridge, samples[period:]))


def _faded(first: Samples, second: Samples) -> Samples:
    """Return a cross-fade from `first` to `second`, of their length."""
    mixed = first + (second.astype(np.float32) - first) * _ramp(len(first))
    return np.rint(mixed, out=mixed).astype(np.int16)


@lru_cache(maxsize=(LONGEST_PERIOD - SHORTEST_PERIOD) // _STEP + 1)
def _ramp(length: int) -> NDArray[np.float32]:
    ramp = np.linspace(0.0, 1.0, length, endpoint=False, dtype=np.float32)[:, np.newaxis]
    ramp.flags.writeable = False
    return ramp


def _period(samples: Samples, most: int, *, force: bool) -> int:
    longest = min(most, LONGEST_PERIOD, len(samples) // 2)
    if longest < SHORTEST_PERIOD:
        return 0
    mono = samples[: 2 * longest : _STEP].sum(axis=1, dtype=np.float32) / samples.shape[1]
    energy = np.cumsum(mono * mono, dtype=np.float64)
    if energy[-1] < _QUIET * len(mono):
        return longest
    lags, within = _lags(longest // _STEP)
    first = energy[lags - 1]
    power = first * (energy[2 * lags - 1] - first)
    # The row of a lag begins there; of it and of the beginning, as many samples are compared as the lag is long.
    shifted = sliding_window_view(mono, lags[-1])[lags]
    likeness = (shifted * within) @ mono[: lags[-1]] / np.sqrt(np.where(power > 0, power, np.inf))
    best = int(likeness.argmax())
    return int(lags[best]) * _STEP if force or likeness[best] >= _ALIKE else 0


@lru_cache(maxsize=(LONGEST_PERIOD - SHORTEST_PERIOD) // _STEP + 1)
def _lags(longest: int) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Return the lags to be tried, the last one `longest`, and for each of them as many ones as it is long."""
    lags = np.arange(SHORTEST_PERIOD // _STEP, longest + 1)
    within = (np.arange(longest) < lags[:, np.newaxis]).astype(np.float32)
    lags.flags.writeable = within.flags.writeable = False
    return lags, within
