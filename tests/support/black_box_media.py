"""What an application of `tests.support.black_box` makes of pictures and sound; it imports nothing of this project."""

import itertools
import time
from collections import deque
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

import numpy as np
from aiortc import AudioStreamTrack, VideoStreamTrack
from av import AudioFrame, VideoFrame
from numpy.typing import NDArray

SAMPLE_RATE: Final = 48_000
MARKER_HZ: Final = 1000

_CELLS: Final = 80
_KEPT_BLOCKS: Final = 250
_WINDOW: Final = 240


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture as it arrived: its number, and how old it was then (s). `at` is on the monotonic clock."""

    number: int
    age: float
    at: float


def read_stamp(luma: NDArray[np.uint8]) -> tuple[int, int] | None:
    """Read frame number and wall time (0.1 ms) from the 80 cells along the bottom; None if they are not there."""
    height, width = luma.shape
    band = luma[height - max(8, height * 8 // 360) :]
    band = band[len(band) // 4 : len(band) - len(band) // 4]
    value = 0
    for left, right in itertools.pairwise(cell * width // _CELLS for cell in range(_CELLS + 1)):
        margin = (right - left) // 4
        value = value << 1 | int(band[:, left + margin : right - margin].mean() >= 128)
    body = value >> 8 & (1 << 68) - 1
    crc = 0
    for byte in body.to_bytes(9, "big"):
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x107 if crc & 0x80 else 0)) & 0xFF
    if value >> 76 != 0b1010 or crc != value & 0xFF:
        return None
    return body >> 44, body & (1 << 44) - 1


class Media:
    """What arrived in one m-section."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self.pictures: list[Picture] = []
        self.arrived = 0
        """Pictures, with a stamp or without."""
        self.unreadable = 0
        self.blocks = 0
        self.ended = False
        self.luma: NDArray[np.uint8] | None = None
        """The newest picture."""
        self._sound: deque[NDArray[np.float64]] = deque(maxlen=_KEPT_BLOCKS)

    def sound(self) -> NDArray[np.float64]:
        """The newest seconds of sound, one channel, from -1 to 1."""
        return np.concatenate(self._sound)

    def take_picture(self, frame: VideoFrame) -> None:
        plane = frame.planes[0]
        luma = np.frombuffer(bytes(plane), np.uint8).reshape(-1, plane.line_size)[: frame.height, : frame.width]
        self.luma = luma
        self.arrived += 1
        stamp = read_stamp(luma)
        if stamp is None:
            self.unreadable += 1
            return
        number, shown = stamp
        behind = (round(time.time() * 10_000) - shown) % (1 << 44)
        self.pictures.append(Picture(number, behind / 10_000, time.monotonic()))

    def take_sound(self, frame: AudioFrame) -> None:
        samples = np.asarray(frame.to_ndarray(), np.float64).reshape(frame.samples, -1)
        self._sound.append(samples[:, 0] / 32768)
        self.blocks += 1


class Microphone(AudioStreamTrack):
    """A tone of 440 Hz with a peak of -6 dBFS; aiortc takes 3 dB of what is mono."""

    async def recv(self) -> AudioFrame:
        frame = await super().recv()
        assert isinstance(frame, AudioFrame)
        assert frame.pts is not None
        rate = frame.sample_rate
        phase = 2 * np.pi * 440 * (frame.pts + np.arange(frame.samples)) / rate
        tone = 16_384 * np.sin(phase)
        told = AudioFrame.from_ndarray(tone.astype(np.int16)[np.newaxis], format="s16", layout="mono")
        told.sample_rate, told.pts, told.time_base = rate, frame.pts, frame.time_base
        return told


class Voice(AudioStreamTrack):
    """Says something, 48 kHz in one channel, again and again, with a pause of 1.5 s between."""

    def __init__(self, said: NDArray[np.int16]) -> None:
        super().__init__()
        self._sound = np.concatenate([said, np.zeros(SAMPLE_RATE * 3 // 2, np.int16)])

    async def recv(self) -> AudioFrame:
        frame = await super().recv()
        assert isinstance(frame, AudioFrame)
        assert frame.pts is not None
        step = SAMPLE_RATE // frame.sample_rate
        first = frame.pts * step
        told = np.take(self._sound, np.arange(first, first + frame.samples * step), mode="wrap")
        voice = AudioFrame.from_ndarray(told[np.newaxis], format="s16", layout="mono")
        voice.sample_rate, voice.pts = SAMPLE_RATE, first
        voice.time_base = Fraction(1, SAMPLE_RATE)
        return voice


class Camera(VideoStreamTrack):
    """Pictures that are as bright as can be, 320x180."""

    async def recv(self) -> VideoFrame:
        pts, time_base = await self.next_timestamp()
        frame = VideoFrame.from_ndarray(np.full((270, 320), 235, np.uint8), format="yuv420p")
        frame.pts, frame.time_base = pts, time_base
        return frame


def pitch(sound: NDArray[np.float64]) -> float:
    """The strongest frequency in Hz."""
    spectrum = np.abs(np.fft.rfft(sound * np.hanning(len(sound))))
    return float(np.argmax(spectrum)) * SAMPLE_RATE / len(sound)


def bursts(sound: NDArray[np.float64]) -> list[tuple[float, float]]:
    """Where sound begins after silence and how long it lasts, in seconds; a burst that is cut off does not count."""
    windows = sound[: len(sound) // _WINDOW * _WINDOW].reshape(-1, _WINDOW)
    loud = np.sqrt((windows**2).mean(axis=1)) > 0.1
    edges = np.flatnonzero(np.diff(loud.astype(np.int8)))
    starts = [edge + 1 for edge in edges if loud[edge + 1]]
    ends = [edge + 1 for edge in edges if loud[edge]]
    if ends and (not starts or ends[0] < starts[0]):
        ends = ends[1:]
    step = _WINDOW / SAMPLE_RATE
    return [(start * step, (end - start) * step) for start, end in zip(starts, ends, strict=False)]
