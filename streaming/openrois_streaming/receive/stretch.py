"""Shortening and lengthening of sound by one of its periods, which is inaudible. Pure."""

import numpy as np
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
    ramp = np.linspace(0.0, 1.0, len(first), endpoint=False, dtype=np.float32)[:, np.newaxis]
    mixed = first * (1 - ramp) + second * ramp
    return np.rint(mixed).astype(np.int16)


def _period(samples: Samples, most: int, *, force: bool) -> int:
    longest = min(most, LONGEST_PERIOD, len(samples) // 2)
    if longest < SHORTEST_PERIOD:
        return 0
    mono = samples[: 2 * longest : _STEP].astype(np.float32).mean(axis=1)
    if float(np.mean(mono * mono)) < _QUIET:
        return longest
    best, alike = longest, -1.0
    for lag in range(SHORTEST_PERIOD // _STEP, longest // _STEP + 1):
        first, second = mono[:lag], mono[lag : 2 * lag]
        power = float(np.dot(first, first) * np.dot(second, second))
        likeness = float(np.dot(first, second)) / power**0.5 if power > 0 else 0.0
        if likeness > alike:
            best, alike = lag * _STEP, likeness
    return best if force or alike >= _ALIKE else 0
