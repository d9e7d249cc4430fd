"""Delay of the voice behind the mouth: the dark between the lips, compared with the loudness of the sound. Pure."""

from collections import deque
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio, RawVideo
from openrois_streaming.testing.delays import percentile

_STEP = 0.005
"""Seconds between two values of both lines that are compared."""
_FARTHEST = 0.25
_SMOOTH = 0.11
"""Seconds over which the sound's loudness is averaged, as lips take to open or to close."""
_KEPT = 60
"""Seconds."""
_PART = 5.0
"""Seconds of which one offset is told."""
_CLEARLY = 0.7
_DARK = 70
# Where the mouth is, as parts of the picture's height and width.
_ROWS, _COLUMNS = (160 / 360, 215 / 360), (285 / 640, 355 / 640)

_LATES: Final = [float(late) for late in np.arange(-_FARTHEST, _FARTHEST + _STEP / 2, _STEP)]

_Points: TypeAlias = deque[tuple[float, float]]
_Curve: TypeAlias = NDArray[np.float64]
"""Times in the first row, values in the second."""


class Mouth:
    """Compares pictures and sound of the last minute by their times of capture, as the sender's reports tell them."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget what was seen and heard."""
        self._open: _Points = deque(maxlen=60 * _KEPT)
        self._loud: _Points = deque(maxlen=round(_KEPT / _STEP))

    def add_frame(self, frame: RawVideo | RawAudio) -> None:
        """A decoded picture, or a block of sound."""
        if isinstance(frame, RawVideo):
            luma = frame.data[: frame.height]
            (top, bottom), (left, right) = _ROWS, _COLUMNS
            rows = slice(round(top * frame.height), round(bottom * frame.height))
            lips = luma[rows, round(left * frame.width) : round(right * frame.width)]
            self._open.append((frame.captured_at, float(np.mean(lips < _DARK))))
            return
        samples = frame.samples[:, 0].astype(np.float64)
        length = round(_STEP * SAMPLE_RATE)
        for first in range(0, len(samples) - length + 1, length):
            power = float(np.mean(np.square(samples[first : first + length])))
            self._loud.append((frame.captured_at + (first + length / 2) / SAMPLE_RATE, power**0.5))

    def figures(self) -> dict[str, Any] | None:
        """The seconds by which the sound is later: where both lines are most alike, part by part; None without any."""
        if len(self._open) < 2 or len(self._loud) < 2:
            return None
        begin = max(self._open[0][0], self._loud[0][0]) + _FARTHEST
        end = min(self._open[-1][0], self._loud[-1][0]) - _FARTHEST
        # As arrays, once: the viewer must not stand still for so long that it counts as gone.
        seen, heard = np.array(self._open).T, np.array(self._loud).T
        late = [_late(seen, heard, first) for first in np.arange(begin, end - _PART, _PART)]
        found = sorted(each for each in late if each is not None)
        if not found:
            return None
        either = sorted(map(abs, found))
        return {"parts": len(found), "median": percentile(found, 0.5), "p95": percentile(either, 0.95)}


def _late(mouth: _Curve, sound: _Curve, begin: float) -> float | None:
    """By how much the sound is later in the part from `begin` on; None where mouth and sound are not alike."""
    moments = np.arange(begin, begin + _PART, _STEP)
    seen = _line(mouth, moments)
    alike, late = max((_alike(seen, _loudness(sound, moments + late)), late) for late in _LATES)
    return late if alike > _CLEARLY else None


def _line(points: _Curve, moments: NDArray[np.float64]) -> NDArray[np.float64]:
    times, values = points
    return np.asarray(np.interp(moments, times, values), np.float64)


def _loudness(points: _Curve, moments: NDArray[np.float64]) -> NDArray[np.float64]:
    width = round(_SMOOTH / _STEP)
    return np.convolve(_line(points, moments), np.full(width, 1 / width), "same")


def _alike(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    return float(np.corrcoef(first, second)[0, 1]) if np.ptp(first) and np.ptp(second) else 0.0
