"""Media that an application sends: pictures that were encoded before, and sound with a marker every half second."""

import asyncio
import math
import time
from fractions import Fraction
from typing import Any, Final

import av
import numpy as np
from aiortc import MediaStreamTrack
from numpy.typing import NDArray
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source import stamp
from openrois_streaming.source.source import RawVideo

WIDTH, HEIGHT, FPS = 1280, 720, 30
BITRATE: Final = 1_500_000
FRAMES: Final = 30
"""Pictures that are sent over and over; the first of them is a key frame."""

SAMPLES: Final = 960
SAMPLE_RATE: Final = 48_000
MARKER_PACKETS: Final = 25
"""Each so many packets of sound begin with a marker."""
_MARKER: Final = 480
_THRESHOLD: Final = 3000
# Markers of one sound are further apart than this; what comes sooner is the same one.
_APART: Final = 0.1


def encoded(mime_type: str) -> list[bytes]:
    """Pictures of a moving texture, each stamped with its number."""
    encoder = VideoEncoder(mime_type, bitrate=BITRATE, frame_rate=FPS)
    random = np.random.default_rng(1)
    texture = random.integers(60, 190, (HEIGHT // 8, WIDTH // 8), np.uint8).repeat(8, 0).repeat(8, 1)
    pictures = []
    for number in range(FRAMES):
        data = np.full((HEIGHT * 3 // 2, WIDTH), 128, np.uint8)
        data[:HEIGHT] = np.roll(texture, 4 * number, axis=1)
        stamp.write(data[:HEIGHT], number, 0.0)
        raw = RawVideo(data, "i420", WIDTH, HEIGHT, number, number / FPS)
        (chunk,) = encoder.encode(raw, key_frame=number == 0)
        pictures.append(bytes(chunk.data))
    return pictures


class PictureTrack(MediaStreamTrack):
    """Sends `pictures` over and over; `sent_at` says when each number was handed over for the last time."""

    kind = "video"

    def __init__(self, pictures: list[bytes]) -> None:
        super().__init__()
        self.sent_at: dict[int, float] = {}
        self._pictures = pictures
        self._began: float | None = None
        self._number = 0

    async def recv(self) -> Any:
        """The next picture, when its time has come."""
        self._began = self._began or time.monotonic()
        await asyncio.sleep(max(self._began + self._number / FPS - time.monotonic(), 0))
        index = self._number % FRAMES
        packet: Any = av.Packet(self._pictures[index])
        packet.pts = self._number * 90_000 // FPS
        packet.time_base = Fraction(1, 90_000)
        self._number += 1
        self.sent_at[index] = time.monotonic()
        return packet


class SoundTrack(MediaStreamTrack):
    """Sends silence with markers; `markers` are the times at which packets that begin with one were handed over."""

    kind = "audio"

    def __init__(self) -> None:
        super().__init__()
        self.markers: list[float] = []
        self._began: float | None = None
        self._number = 0
        wave = 16_000 * np.sin(2 * math.pi * 1000 * np.arange(_MARKER) / SAMPLE_RATE)
        self._marker = np.zeros(SAMPLES, np.int16)
        self._marker[:_MARKER] = wave.astype(np.int16)

    async def recv(self) -> av.AudioFrame:
        """The next 20 ms, when their time has come."""
        self._began = self._began or time.monotonic()
        await asyncio.sleep(max(self._began + self._number * SAMPLES / SAMPLE_RATE - time.monotonic(), 0))
        marked = self._number % MARKER_PACKETS == 0
        samples = self._marker if marked else np.zeros(SAMPLES, np.int16)
        frame = av.AudioFrame.from_ndarray(samples.reshape(1, -1), format="s16", layout="mono")
        frame.sample_rate, frame.pts, frame.time_base = SAMPLE_RATE, self._number * SAMPLES, Fraction(1, SAMPLE_RATE)
        self._number += 1
        if marked:
            self.markers.append(time.monotonic())
        return frame


class MarkerFinder:
    """Finds when markers were heard; a sample of a block is heard when the block came and those before it are over."""

    def __init__(self) -> None:
        self.heard: list[float] = []

    def add(self, samples: NDArray[np.int16], now: float) -> None:
        """A block, of shape (n, channels), came at `now`."""
        loud = np.flatnonzero(np.abs(samples[:, 0].astype(np.int32)) > _THRESHOLD)
        if len(loud):
            at = now + float(loud[0]) / SAMPLE_RATE
            if not self.heard or at - self.heard[-1] > _APART:
                self.heard.append(at)


def delays(sent: list[float], heard: list[float]) -> list[tuple[float, float]]:
    """Of each marker that was heard, when it was sent and how long it took; each belongs to the last one before it.

    aiortc's receiver, which is the slowest, never holds as much as lies between two markers.
    """
    found = []
    for at in heard:
        before = [each for each in sent if each <= at]
        if before:
            found.append((before[-1], at - before[-1]))
    return found
