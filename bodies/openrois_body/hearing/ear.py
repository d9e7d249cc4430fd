"""The microphone's sound for all senses of hearing, followed by silence when it ends or is another visitor's."""

import asyncio
from collections.abc import Callable
from typing import Final

import numpy as np
from openrois_media.devices import Microphone
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from openrois.aio.listeners import Listeners
from openrois_body.hearing.bearing import is_stereo

__all__ = ["GONE", "Ear"]

GONE: Final = 0.5
"""Seconds without sound after which it counts as over: a microphone that is there gives a block every 10 ms."""
_MOST: Final = 2
_SILENCE: Final = 1.0
"""Seconds of silence that follow then, at once, so that everything that lasts until silence ends."""


class Ear:
    """Passes the microphone's sound on to its listeners. `run` has to run, to notice its end.

    Args:
        microphone: source of the sound.
        clock: the media clock.
    """

    def __init__(self, microphone: Microphone, clock: MediaClock) -> None:
        self.channels = 0
        """Number of different channels of the microphone: 1 or 2; 0 before the first sound."""
        self.sender = ""
        """The visitor_ref of whose sound it is, and of the silence after it; empty for the body's own microphone."""
        self.forgotten: Listeners[()] = Listeners()
        """Called when what was heard until now is to be forgotten: what lasts ends, and nothing else is announced."""
        self._clock = clock
        self._listeners: Listeners[RawAudio] = Listeners()
        self._sounding = asyncio.Event()
        self._came_at = -GONE
        self._next_at = 0.0
        """Capture time of the next block, if none is missing between."""
        microphone.sound_to_recognise.add(self._on_sound)

    @property
    def sounding(self) -> bool:
        """Whether blocks of sound arrive, loud or not; if so, the listeners get silence when they end."""
        return self._sounding.is_set()

    def listen(self, listener: Callable[[RawAudio], None]) -> Callable[[], None]:
        """Pass each block of sound on to `listener` from now on; return a function that ends that."""
        return self._listeners.add(listener)

    def forget_sound(self, sender: str) -> None:
        """Forget the sound of this visitor, if it is what is heard: nothing is to be told of it any more."""
        if self.sounding and sender == self.sender:
            self._sounding.clear()
            self.channels = 0
            self.forgotten.notify_all()

    async def run(self) -> None:
        """Pass on silence whenever sound ends, until cancelled."""
        while True:
            await self._sounding.wait()
            await self._clock.sleep_until(self._came_at + GONE)
            if self._clock.now() - self._came_at >= GONE:
                self._end_sound()

    def _end_sound(self) -> None:
        self._sounding.clear()
        self.channels = 0
        silence = np.zeros((round(_SILENCE * SAMPLE_RATE), 2), np.int16)
        self._listeners.notify_all(RawAudio(silence, self._next_at, sender=self.sender))

    def _on_sound(self, sound: RawAudio) -> None:
        if sound.sender != self.sender:
            if self.sounding:
                # What lasts is of the former visitor, and ends with its sound.
                self._end_sound()
            self.sender = sound.sender
        self._came_at = self._clock.now()
        self._next_at = sound.captured_at + len(sound.samples) / SAMPLE_RATE
        self._sounding.set()
        if self.channels < _MOST and sound.samples.any():
            self.channels = _MOST if is_stereo(sound.samples) else 1
        self._listeners.notify_all(sound)
