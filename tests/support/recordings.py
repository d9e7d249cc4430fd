"""Recordings, read back."""

from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import stamp
from openrois_streaming.source.stamp import Stamp


@dataclass(frozen=True, slots=True)
class Recorded:
    """A file as a player has it.

    Attributes:
        codecs: of each kind of media.
        seconds: its length.
        pictures: when each picture is shown, its size, and its stamp if it bears one.
        sound: one channel, 48 kHz, from 0 on.
    """

    codecs: dict[str, str]
    seconds: float
    pictures: list[tuple[float, tuple[int, int], Stamp | None]]
    sound: NDArray[np.float32]


def read_back(path: Path) -> Recorded:
    """Decode a recording."""
    with av.open(str(path), "r") as opened:
        codecs: dict[str, str] = {each.type: each.codec_context.name for each in opened.streams}
        seconds = (opened.duration or 0) / 1e6
        pictures = []
        if opened.streams.video:
            for frame in opened.decode(video=0):
                grey = np.asarray(frame.to_ndarray(format="gray"), np.uint8)
                pictures.append((float(frame.time or 0), (frame.width, frame.height), stamp.read(grey)))
    return Recorded(codecs, seconds, pictures, _sound(path) if "audio" in codecs else np.empty(0, np.float32))


def _sound(path: Path) -> NDArray[np.float32]:
    pieces: list[tuple[int, NDArray[np.float32]]] = []
    with av.open(str(path), "r") as opened:
        resampler = av.AudioResampler("flt", "mono", 48_000)
        for frame in opened.decode(audio=0):
            start = round(float(frame.time or 0) * 48_000)
            pieces += [(start, each.to_ndarray()[0]) for each in resampler.resample(frame)]
    length = max(start + len(samples) for start, samples in pieces)
    sound = np.zeros(length, np.float32)
    for start, samples in pieces:
        first = max(-start, 0)
        sound[start + first : start + len(samples)] = samples[first:]
    return sound


def onsets(sound: NDArray[np.float32], level: float = 0.1) -> list[float]:
    """Return the times at which sound begins after at least 100 ms of silence, in seconds."""
    loud = np.flatnonzero(np.abs(sound) > level)
    if not len(loud):
        return []
    first = np.concatenate(([True], np.diff(loud) > 4800))
    return [float(each) / 48_000 for each in loud[first]]
