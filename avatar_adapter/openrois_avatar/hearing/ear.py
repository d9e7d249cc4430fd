"""The ear of all senses of hearing: what the microphone gives, and silence when it ends."""

import asyncio
from collections.abc import Callable
from typing import Final

import numpy as np
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from openrois.aio.listeners import Listeners
from openrois_avatar.devices import Microphone
from openrois_avatar.hearing.bearing import is_stereo

__all__ = ["GONE", "Ear"]

GONE: Final = 0.5
"""Seconds without sound after which it counts as over: a microphone that is there gives a block every 10 ms."""
_MOST: Final = 2
_SILENCE: Final = 1.0
"""Seconds of silence that are heard then, at once: everything that lasts until it is quiet has ended after that."""


class Ear:
    """Passes the microphone's sound on to those who listen. `run` must run for its end to be heard.

    Args:
        microphone: whose sound.
        clock: the media clock.
    """

    def __init__(self, microphone: Microphone, clock: MediaClock) -> None:
        self.channels = 0
        """How many different channels the microphone was heard to have: 1 or 2; 0 if there was no sound yet."""
        self._clock = clock
        self._listeners: Listeners[RawAudio] = Listeners()
        self._sounding = asyncio.Event()
        self._came_at = -GONE
        self._next_at = 0.0
        """When what comes next was captured, if nothing is missing between."""
        microphone.heard.add(self._hear)

    @property
    def sounding(self) -> bool:
        """Whether there is sound, loud or not; if so, those who listen will hear when it ends."""
        return self._sounding.is_set()

    def listen(self, listener: Callable[[RawAudio], None]) -> Callable[[], None]:
        """Pass each block of sound on to `listener` from now on; return what ends that."""
        return self._listeners.add(listener)

    async def run(self) -> None:
        """Hear for ever when sound ends."""
        while True:
            await self._sounding.wait()
            await self._clock.sleep_until(self._came_at + GONE)
            if self._clock.now() - self._came_at >= GONE:
                self._sounding.clear()
                self.channels = 0
                self._listeners.tell(RawAudio(np.zeros((round(_SILENCE * SAMPLE_RATE), 2), np.int16), self._next_at))

    def _hear(self, sound: RawAudio) -> None:
        self._came_at = self._clock.now()
        self._next_at = sound.captured_at + len(sound.samples) / SAMPLE_RATE
        self._sounding.set()
        if self.channels < _MOST and sound.samples.any():
            self.channels = _MOST if is_stereo(sound.samples) else 1
        self._listeners.tell(sound)
