"""Moving pictures with as much in them as a camera's: what fills a bit rate, unlike colour bars."""

import itertools
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawVideo

from openrois_bench.streams.fanout.runs import FPS

__all__ = ["Grain"]

_GRAIN: Final = 2
_PATCH: Final = 16
"""Pixels of a patch of the texture; finer ones would make it noise."""


class Grain:
    """A textured wall and before it a textured disc that goes round once a second, both with the grain of a sensor.

    The pictures are I420. All of them are drawn beforehand and given out read-only, so that they cost nothing while
    they are measured with; every second is the same.

    Args:
        width: of the picture in pixels, even.
        height: of the picture in pixels, even.
        clock: by which the frames are paced and dated.
    """

    def __init__(self, width: int, height: int, *, clock: MediaClock) -> None:
        self.width, self.height = width, height
        self._clock = clock
        self._pictures = _second(width, height)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        """Yield the iterator of frames; it does not end."""
        yield self._frames(self._clock.now())

    async def _frames(self, epoch: float) -> AsyncIterator[RawVideo]:
        for number in itertools.count():
            moment = epoch + number / FPS
            await self._clock.sleep_until(moment)
            picture = self._pictures[number % FPS]
            yield RawVideo(picture, "i420", self.width, self.height, number, moment)


def _second(width: int, height: int) -> list[NDArray[np.uint8]]:
    random = np.random.default_rng(0)
    wall, disc = (_texture(random, width, height) for _ in range(2))
    pictures = []
    for number in range(FPS):
        luma = wall.copy()
        angle = 2 * math.pi * number / FPS
        centre = round(width / 2 + width / 8 * math.cos(angle)), round(height / 2 + height / 8 * math.sin(angle))
        mask = cv2.circle(np.zeros_like(luma, np.uint8), centre, height // 4, 255, -1).astype(bool)
        luma[mask] = disc[mask]
        luma += random.integers(-_GRAIN, _GRAIN + 1, luma.shape)
        picture = np.full((height * 3 // 2, width), 128, np.uint8)
        picture[:height] = luma.clip(16, 235)
        picture.flags.writeable = False
        pictures.append(picture)
    return pictures


def _texture(random: np.random.Generator, width: int, height: int) -> NDArray[np.float64]:
    patches = random.uniform(40, 210, (height // _PATCH, width // _PATCH))
    return np.asarray(cv2.resize(patches, (width, height), interpolation=cv2.INTER_CUBIC))
