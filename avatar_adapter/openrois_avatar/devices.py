"""The operator as the avatar's adapter hears and sees them, for components to read: sound, level, picture."""

import asyncio
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.loudness import SILENCE, Level, LevelMeter
from openrois_streaming.source.shared_inlet import SharedInlet
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.aio.listeners import Listeners

__all__ = ["LEVEL_INTERVAL", "Camera", "Microphone"]

LEVEL_INTERVAL: Final = 0.2
"""Seconds between two looks at the level."""
_BLOCKS: Final = 50
"""Blocks of sound that may wait while the event loop is busy: half a second of what a receiver gives."""


class Microphone:
    """The sound of the operator's microphone; silence while there is none. `listen` must run for anything to be heard.

    Args:
        clock: for the pace of the levels.
    """

    def __init__(self, clock: MediaClock) -> None:
        self.inlet: SharedInlet[RawAudio] = SharedInlet("microphone")
        self.heard: Listeners[RawAudio] = Listeners()
        """Are told each block of sound, when it comes."""
        self.level_changed: Listeners[Level] = Listeners()
        """Are told the level of the last `LEVEL_INTERVAL` when it is another one."""
        self.level = SILENCE
        self._clock = clock
        self._meter = LevelMeter()

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a microphone, suspended or not."""
        return self.inlet.stream_id is not None

    async def listen(self) -> None:
        """Hear for ever."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._measure(), name="microphone level")
            async with self.inlet.subscribe(_BLOCKS) as blocks:
                while True:
                    sound = await blocks.get()
                    self._meter.add(sound.samples)
                    self.heard.tell(sound)

    async def _measure(self) -> None:
        while True:
            if self.level == SILENCE:
                await self.inlet.plugged()
            await self._clock.sleep_until(self._clock.now() + LEVEL_INTERVAL)
            level = self._meter.read()
            if level != self.level:
                self.level = level
                self.level_changed.tell(level)


class Camera:
    """The pictures of the operator's camera. They are decoded while somebody subscribes to `inlet` or waits for one."""

    def __init__(self) -> None:
        self.inlet: SharedInlet[RawVideo] = SharedInlet("camera")

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a camera, suspended or not."""
        return self.inlet.stream_id is not None

    async def picture(self, timeout: float = 2.0) -> RawVideo:
        """The next picture.

        Raises:
            TimeoutError: none came within `timeout` seconds.
        """
        async with asyncio.timeout(timeout), self.inlet.subscribe(1) as pictures:
            return await pictures.get()
