"""Talking head before a textured wall, with as much detail as a camera's picture."""

import math
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawVideo
from openrois_streaming.synthetic.marks import BLACK, GREY, WHITE, colour_planes, draw_lamp, shines
from openrois_streaming.synthetic.pacing import due

_GRAIN = 2
"""By how much the noise of a sensor changes the luma of a pixel."""
_PATCH = 16
"""Pixels of a patch of the texture; finer ones would make it noise."""
_SKIN = (108, 156)
_LIPS = (118, 170)

# Parts of a picture's height.
_HEAD = 0.34
_SWAY = 0.06


class TalkingHead:
    """A head that sways and talks, its mouth wide open at each whole second of wall time, and the lamp.

    All pictures of a second are drawn when this is made, and given out read-only: they cost nothing while something is
    measured with them, and a good part of a second before that. Paced and numbered as `ColourBars`.

    Args:
        width: of the picture in pixels, even, 160 or more.
        height: of the picture in pixels, even, 90 or more.
        fps: frames per second, at least 1.
        clock: by which the frames are paced and dated.

    Raises:
        ValueError: a size or pace is out of range.
    """

    def __init__(self, width: int = 640, height: int = 360, fps: float = 30.0, *, clock: MediaClock) -> None:
        if width < 160 or height < 90 or width % 2 or height % 2 or fps < 1:
            raise ValueError(
                f"a size of 160x90 or more, even, and fps from 1 on are needed, not {width}x{height} at {fps}"
            )
        self.width, self.height, self.fps = width, height, fps
        self._clock = clock
        self._epoch: float | None = None
        self._given = -1
        self._pictures = _second(width, height, fps)

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
            phase = wall_at(self._clock, moment) % 1
            picture = self._pictures[int(phase * len(self._pictures))]
            yield RawVideo(picture, "i420", self.width, self.height, number, moment)


def _second(width: int, height: int, fps: float) -> list[NDArray[np.uint8]]:
    random = np.random.default_rng(0)
    wall, skin = (_texture(random, width, height) for _ in range(2))
    count = round(fps)
    pictures = []
    for number in range(count):
        phase = number / count
        picture = np.full((height * 3 // 2, width), GREY, np.uint8)
        luma = wall.copy()
        _draw_head(luma, colour_planes(picture, height), skin, phase)
        luma += random.integers(-_GRAIN, _GRAIN + 1, luma.shape)
        picture[:height] = luma.clip(BLACK, WHITE)
        draw_lamp(picture, shines(phase, fps))
        picture.flags.writeable = False
        pictures.append(picture)
    return pictures


def _draw_head(luma: NDArray[np.float64], colours: NDArray[np.uint8], skin: NDArray[np.float64], phase: float) -> None:
    height, width = luma.shape
    turn = 2 * math.pi * phase
    x, y = width / 2 + height * _SWAY * math.sin(turn), height * (0.5 + _SWAY / 3 * math.cos(2 * turn))
    size = height * _HEAD

    def ellipse(dx: float, dy: float, wide: float, high: float) -> NDArray[np.bool_]:
        """An ellipse in the picture; all in parts of the head's size."""
        centre = round(x + dx * size), round(y + dy * size)
        axes = max(round(wide * size), 1), max(round(high * size), 1)
        return cv2.ellipse(np.zeros((height, width), np.uint8), centre, axes, 0, 0, 360, 1, -1).astype(bool)

    head = ellipse(0, 0, 0.75, 1)
    luma[head] = 110 + skin[head] / 3
    hair = ellipse(0, -0.45, 0.78, 0.6) & ~ellipse(0, 0.1, 0.66, 0.8)
    luma[hair] = 30 + skin[hair] / 5
    eye = 0.02 if 0.6 < phase < 0.7 else 0.09
    for side in (-0.3, 0.3):
        luma[ellipse(side, -0.15, 0.14, eye)] = 220
        luma[ellipse(side + 0.04 * math.sin(turn), -0.15, 0.06, min(eye, 0.06))] = 30
    mouth = ellipse(0, 0.5, 0.26, 0.04 + 0.2 * _opening(phase))
    luma[mouth] = 50
    for mask, tints in ((head & ~hair, _SKIN), (mouth, _LIPS)):
        for plane, tint in zip(colours, tints, strict=True):
            plane[mask[::2, ::2]] = tint


def _opening(phase: float) -> float:
    """Return the openness of the mouth, 0..1: wide with the marker of the tone, and then as if it spoke."""
    if phase < 0.1:
        return 1.0
    return 0.6 * abs(math.sin(6 * math.pi * phase)) if 0.3 < phase < 0.85 else 0.0


def _texture(random: np.random.Generator, width: int, height: int) -> NDArray[np.float64]:
    patches = random.uniform(60, 190, (height // _PATCH, width // _PATCH))
    return np.asarray(cv2.resize(patches, (width, height), interpolation=cv2.INTER_CUBIC))
