"""Pictures and sounds that are made here, for testers: what arrives can be compared with what must have been sent.

Give them to a publisher like any source::

    clock = SystemClock()
    video = VideoPublisher(ColourBars(clock=clock), clock=clock, stamp=True)
    audio = AudioPublisher(Tone(clock=clock), clock=clock)

Published with `stamp=True`, each picture carries its number and the time of its capture (see `stamp`), from which loss
and delay follow; the tone at each whole second of wall time, seen beside that stamp, gives the lip sync.
"""

import math
import time
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source import SAMPLE_RATE, RawAudio, RawVideo

MARKER_HZ = 1000
MARKER_SECONDS = 0.05
"""The tone's marker starts at each whole second of wall time, at phase 0."""

BLOCK_SAMPLES = SAMPLE_RATE // 50

# White, yellow, cyan, green, magenta, red and blue at 75 % (SMPTE EG 1), in BGR order.
_BARS = [(191, 191, 191), (0, 191, 191), (191, 191, 0), (0, 191, 0), (191, 0, 191), (0, 0, 191), (191, 0, 0)]
_BLACK, _WHITE, _GREY = 16, 235, 128
_GLYPHS = "0123456789:.# "
_MARGIN = 8
# A day of frames at 60 fps has seven digits.
_CAPTION_LENGTH = len("00:00:00.000 #0000000")

# Seconds in which the dot crosses the picture.
_CROSSING = 4.0
_AMPLITUDE = 16_000
# A sound card keeps this much for a reader that is late; with 20 ms a block it is 0.2 s.
_KEPT_BLOCKS = 10


class ColourBars:
    """Seven colour bars, a dot that crosses the picture in four seconds, and the wall time (UTC) with the frame number.

    The frames come at `fps` a second, without drift: number n shows, and is captured at, the moment of the first
    opening plus n / fps. A reader that is late misses numbers; so does one that closes the source and opens it again.
    The pictures are I420.

    Args:
        width: of the picture in pixels, even, 160 or more.
        height: of the picture in pixels, even, 90 or more.
        fps: frames per second, above 0.
        clock: by which the frames are paced and dated.

    Raises:
        ValueError: a size or pace that cannot be.
    """

    def __init__(self, width: int = 640, height: int = 360, fps: float = 30.0, *, clock: MediaClock) -> None:
        if width < 160 or height < 90 or width % 2 or height % 2 or fps <= 0:
            raise ValueError(f"no colour bars of {width}x{height} at {fps} fps")
        self.width, self.height, self.fps = width, height, fps
        self._clock = clock
        self._epoch: float | None = None
        self._glyphs = _glyphs(height)
        self._background = _bars(width, height)
        self._blacken_caption()
        radius = height // 40 * 2
        y, x = np.ogrid[-radius:radius, -radius:radius]
        self._dot: NDArray[np.bool_] = (x + 0.5) ** 2 + (y + 0.5) ** 2 < radius**2

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        """Yield the iterator of frames; it does not end."""
        if self._epoch is None:
            self._epoch = self._clock.now()
        async with aclosing(self._frames(self._epoch)) as frames:
            yield frames

    async def _frames(self, epoch: float) -> AsyncGenerator[RawVideo, None]:
        async for number in _due(self._clock, epoch, self.fps, patience=0):
            moment = epoch + number / self.fps
            picture = self._draw(number, wall_at(self._clock, moment))
            yield RawVideo(picture, "i420", self.width, self.height, number, moment)

    def _blacken_caption(self) -> None:
        rows, columns = self._glyphs["0"].shape
        right = min(_MARGIN + columns * _CAPTION_LENGTH, self.width - _MARGIN)
        self._background[_MARGIN : _MARGIN + rows, _MARGIN:right] = _BLACK
        colours = _colour_planes(self._background, self.height)
        colours[:, _MARGIN // 2 : (_MARGIN + rows) // 2, _MARGIN // 2 : right // 2] = _GREY

    def _draw(self, number: int, wall: float) -> NDArray[np.uint8]:
        picture = self._background.copy()
        text = np.concatenate([self._glyphs[character] for character in _caption(number, wall)], axis=1)
        text = text[:, : self.width - 2 * _MARGIN]
        picture[_MARGIN : _MARGIN + text.shape[0], _MARGIN : _MARGIN + text.shape[1]] = text
        self._draw_dot(picture, (number / self.fps) % _CROSSING / _CROSSING)
        return picture

    def _draw_dot(self, picture: NDArray[np.uint8], progress: float) -> None:
        size = len(self._dot)
        left, top = int(progress * (self.width - size)) // 2, (self.height - size) // 4
        picture[2 * top : 2 * top + size, 2 * left : 2 * left + size][self._dot] = _WHITE
        for plane in _colour_planes(picture, self.height):
            plane[top : top + size // 2, left : left + size // 2][self._dot[::2, ::2]] = _GREY


class Tone:
    """Silence, with a burst of 1 kHz and 50 ms at each whole second of wall time.

    Blocks of 20 ms come when the moment of their first sample has come, without drift; a reader that is late by up to
    0.2 s loses nothing, one that is later misses blocks. When the wall clock is stepped, the bursts follow.

    Args:
        channels: 1 or 2, all the same.
        clock: by which the blocks are paced and dated.
    """

    def __init__(self, channels: int = 1, *, clock: MediaClock) -> None:
        if channels not in (1, 2):
            raise ValueError(f"no tone of {channels} channels")
        self.channels = channels
        self._clock = clock
        self._epoch: float | None = None

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Yield the iterator of blocks; it does not end."""
        if self._epoch is None:
            self._epoch = self._clock.now()
        async with aclosing(self._blocks(self._epoch)) as blocks:
            yield blocks

    async def _blocks(self, epoch: float) -> AsyncGenerator[RawAudio, None]:
        offset = wall_at(self._clock, 0.0)
        async for number in _due(self._clock, epoch, SAMPLE_RATE / BLOCK_SAMPLES, patience=_KEPT_BLOCKS):
            moment = epoch + number * BLOCK_SAMPLES / SAMPLE_RATE
            if MARKER_SECONDS < (moment + offset) % 1 < 0.9:
                # Read anew only between the bursts: a reading that is off by a delay must not tear one.
                offset = wall_at(self._clock, 0.0)
            yield RawAudio(np.repeat(_marker(moment + offset)[:, np.newaxis], self.channels, axis=1), moment)


def _marker(wall: float) -> NDArray[np.int16]:
    """The block whose first sample is at `wall`."""
    since_second = (wall % 1 + np.arange(BLOCK_SAMPLES) / SAMPLE_RATE) % 1
    wave = _AMPLITUDE * np.sin(2 * math.pi * MARKER_HZ * since_second)
    return np.where(since_second < MARKER_SECONDS, wave, 0).astype(np.int16)


async def _due(clock: MediaClock, epoch: float, rate: float, *, patience: int) -> AsyncIterator[int]:
    """Yield the numbers n, each when `epoch + n / rate` has come, and of those that are late at most `patience`."""
    number = math.ceil((clock.now() - epoch) * rate - 1e-6)
    while True:
        await clock.sleep_until(epoch + number / rate)
        number = max(number, math.floor((clock.now() - epoch) * rate) - patience)
        yield number
        number += 1


def _bars(width: int, height: int) -> NDArray[np.uint8]:
    colours = np.array(_BARS, np.uint8)[np.arange(width) * len(_BARS) // width]
    picture = cv2.cvtColor(np.broadcast_to(colours, (height, width, 3)).copy(), cv2.COLOR_BGR2YUV_I420)
    return np.asarray(picture, np.uint8)


def _colour_planes(picture: NDArray[np.uint8], height: int) -> NDArray[np.uint8]:
    """U and V of an I420 picture as views of shape (2, height / 2, width / 2)."""
    width = picture.shape[1]
    return picture.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)


def _caption(number: int, wall: float) -> str:
    milliseconds = round(wall * 1000)
    moment = time.strftime("%H:%M:%S", time.gmtime(milliseconds // 1000))
    return f"{moment}.{milliseconds % 1000:03d} #{number}"


def _glyphs(height: int) -> dict[str, NDArray[np.uint8]]:
    """A luma bitmap of each character of a caption, all of one even size, for a picture of `height` rows."""
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, height / 480
    sizes = [cv2.getTextSize(character, font, scale, 1)[0] for character in _GLYPHS]
    rows, columns = (max(size[axis] for size in sizes) // 2 * 2 + 4 for axis in (1, 0))
    glyphs = {}
    for character in _GLYPHS:
        bitmap = np.full((rows, columns), _BLACK, np.uint8)
        cv2.putText(bitmap, character, (1, rows - 3), font, scale, _WHITE, 1, cv2.LINE_AA)
        glyphs[character] = bitmap
    return glyphs
