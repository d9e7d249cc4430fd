"""Operator's microphone and camera in the adapter, for components: sound, level, picture."""

import asyncio
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.loudness import SILENCE, Level, LevelMeter
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.aio.listeners import Listeners
from openrois_media.uplinks import AudioUplink, VideoUplink

__all__ = ["LEVEL_INTERVAL", "Camera", "Microphone"]

LEVEL_INTERVAL: Final = 0.2
"""Seconds between two readings of the level."""
_BLOCKS: Final = 50
"""Blocks of sound that may wait while the event loop is busy: half a second."""


class Microphone:
    """Operator's microphone; silence while there is none. It is read only while `listen` runs.

    Args:
        clock: times the levels.
    """

    def __init__(self, clock: MediaClock) -> None:
        self.inlet = AudioUplink("microphone")
        self.sound_received: Listeners[RawAudio] = Listeners()
        """Listeners to each block of sound."""
        self.level_changed: Listeners[Level] = Listeners()
        """Listeners to changes of the level over the last `LEVEL_INTERVAL`."""
        self.level = SILENCE
        self._clock = clock
        self._meter = LevelMeter()

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a microphone, suspended or not."""
        return self.inlet.stream_id is not None

    async def listen(self) -> None:
        """Read the microphone for ever."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._measure(), name="microphone level")
            async with self.inlet.subscribe(_BLOCKS) as blocks:
                while True:
                    sound = await blocks.get()
                    self._meter.add(sound.samples)
                    self.sound_received.notify_all(sound)

    async def _measure(self) -> None:
        while True:
            if self.level == SILENCE:
                await self.inlet.plugged()
            await self._clock.sleep_until(self._clock.now() + LEVEL_INTERVAL)
            level = self._meter.read()
            if level != self.level:
                self.level = level
                self.level_changed.notify_all(level)


class Camera:
    """Operator's camera. Its pictures are decoded while `inlet` has a subscriber."""

    def __init__(self) -> None:
        self.inlet = VideoUplink("camera")

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a camera, suspended or not."""
        return self.inlet.stream_id is not None

    async def picture(self, timeout: float = 2.0) -> RawVideo:
        """Return the next picture.

        Raises:
            TimeoutError: none came within `timeout` seconds.
        """
        async with asyncio.timeout(timeout), self.inlet.subscribe(1) as pictures:
            return await pictures.get()
