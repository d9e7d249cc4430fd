"""Seven colour bars, a dot that crosses them, the time of day, and a lamp."""

import time
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawVideo
from openrois_streaming.synthetic.marks import BLACK, GREY, WHITE, colour_planes, draw_lamp, shines
from openrois_streaming.synthetic.pacing import due

# White, yellow, cyan, green, magenta, red and blue at 75 % (SMPTE EG 1), in BGR order.
_BARS = [(191, 191, 191), (0, 191, 191), (191, 191, 0), (0, 191, 0), (191, 0, 191), (0, 0, 191), (191, 0, 0)]
_GLYPHS = "0123456789:.# "
_MARGIN = 8
# A day of frames at 60 fps has seven digits.
_CAPTION_LENGTH = len("00:00:00.000 #0000000")

# Seconds in which the dot crosses the picture.
_CROSSING = 4.0


class ColourBars:
    """Seven colour bars, a dot that crosses the picture in four seconds, the wall time (UTC), the frame number, a lamp.

    The lamp shines at the begin of each second of wall time.

    The frames come at `fps` a second, without drift: number n shows, and is captured at, the moment of the first
    opening plus n / fps. A reader that is late misses numbers; so does one that closes the source and opens it again.
    The pictures are I420.

    Args:
        width: of the picture in pixels, even, 160 or more.
        height: of the picture in pixels, even, 90 or more.
        fps: frames per second, above 0.
        clock: by which the frames are paced and dated.

    Raises:
        ValueError: a size or pace is out of range.
    """

    def __init__(self, width: int = 640, height: int = 360, fps: float = 30.0, *, clock: MediaClock) -> None:
        if width < 160 or height < 90 or width % 2 or height % 2 or fps <= 0:
            raise ValueError(
                f"a size of 160x90 or more, even, and fps above 0 are needed, not {width}x{height} at {fps}"
            )
        self.width, self.height, self.fps = width, height, fps
        self._clock = clock
        self._epoch: float | None = None
        self._given = -1
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
        async for number in due(self._clock, epoch, self.fps, patience=0, after=self._given):
            self._given = number
            moment = epoch + number / self.fps
            picture = self._draw(number, wall_at(self._clock, moment))
            yield RawVideo(picture, "i420", self.width, self.height, number, moment)

    def _blacken_caption(self) -> None:
        rows, columns = self._glyphs["0"].shape
        right = min(_MARGIN + columns * _CAPTION_LENGTH, self.width - _MARGIN)
        self._background[_MARGIN : _MARGIN + rows, _MARGIN:right] = BLACK
        colours = colour_planes(self._background, self.height)
        colours[:, _MARGIN // 2 : (_MARGIN + rows) // 2, _MARGIN // 2 : right // 2] = GREY

    def _draw(self, number: int, wall: float) -> NDArray[np.uint8]:
        picture = self._background.copy()
        text = np.concatenate([self._glyphs[character] for character in _caption(number, wall)], axis=1)
        text = text[:, : self.width - 2 * _MARGIN]
        picture[_MARGIN : _MARGIN + text.shape[0], _MARGIN : _MARGIN + text.shape[1]] = text
        self._draw_dot(picture, (number / self.fps) % _CROSSING / _CROSSING)
        draw_lamp(picture, shines(wall, self.fps))
        return picture

    def _draw_dot(self, picture: NDArray[np.uint8], progress: float) -> None:
        size = len(self._dot)
        left, top = int(progress * (self.width - size)) // 2, (self.height - size) // 4
        picture[2 * top : 2 * top + size, 2 * left : 2 * left + size][self._dot] = WHITE
        for plane in colour_planes(picture, self.height):
            plane[top : top + size // 2, left : left + size // 2][self._dot[::2, ::2]] = GREY


def _bars(width: int, height: int) -> NDArray[np.uint8]:
    colours = np.array(_BARS, np.uint8)[np.arange(width) * len(_BARS) // width]
    picture = cv2.cvtColor(np.broadcast_to(colours, (height, width, 3)).copy(), cv2.COLOR_BGR2YUV_I420)
    return np.asarray(picture, np.uint8)


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
        bitmap = np.full((rows, columns), BLACK, np.uint8)
        cv2.putText(bitmap, character, (1, rows - 3), font, scale, WHITE, 1, cv2.LINE_AA)
        glyphs[character] = bitmap
    return glyphs
