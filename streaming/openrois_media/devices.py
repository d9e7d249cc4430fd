"""Microphone and camera of the visitor that a body attends to, for components: sound, level, picture.

Each block and picture passes the gate of its visitor's consent here, for each purpose by itself.
"""

import asyncio
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.loudness import SILENCE, Level, LevelMeter
from openrois_streaming.source.source import RawAudio, RawVideo

from openrois.aio.listeners import Listeners
from openrois.types.codes import Purpose
from openrois_media.uplinks import AudioUplink, VideoUplink
from openrois_media.visitors.registry import KEPT, VisitorRegistry
from openrois_media.visitors.visitor import Visitor

__all__ = ["LEVEL_INTERVAL", "Camera", "Microphone"]

LEVEL_INTERVAL: Final = 0.2
"""Seconds between two readings of the level."""
_BLOCKS: Final = 50
"""Blocks of sound that may wait while the event loop is busy: half a second."""


_USES: Final = frozenset({Purpose.LIVE, Purpose.RECOGNITION})
_LIVE: Final = frozenset({Purpose.LIVE})
_RECOGNITION: Final = frozenset({Purpose.RECOGNITION})


class Microphone:
    """Microphone that a body attends to; silence while there is none. It is read only while `listen` runs.

    Args:
        clock: times the levels.
        visitors: those whose microphone it may be; None for a microphone that needs no consent, as the body's own.
    """

    def __init__(self, clock: MediaClock, visitors: VisitorRegistry | None = None) -> None:
        self.inlet = AudioUplink("microphone")
        self.sound_received: Listeners[RawAudio] = Listeners()
        """Listeners to each block of sound that may be heard live."""
        self.sound_to_recognise: Listeners[RawAudio] = Listeners()
        """Listeners to each block of sound in which something may be recognised."""
        self.level_changed: Listeners[Level] = Listeners()
        """Listeners to changes of the level over the last `LEVEL_INTERVAL`."""
        self.level = SILENCE
        self.sender = ""
        """The visitor_ref of whose level it is; empty before the first block."""
        self._visitors = visitors
        self._clock = clock
        self._meter = LevelMeter()
        if visitors is not None:
            visitors.withdrawn.add(self._on_withdrawn)

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a microphone, suspended or not."""
        return self.inlet.stream_id is not None

    def attend(self, visitor: Visitor | None) -> None:
        """Read the microphone of this visitor from now on, or none."""
        _attend(self.inlet, visitor)

    async def listen(self) -> None:
        """Read the microphone for ever."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._measure(), name="microphone level")
            async with self.inlet.subscribe(_BLOCKS) as blocks:
                while True:
                    sound = await blocks.get()
                    if _admits(self._visitors, sound, _LIVE):
                        if sound.sender != self.sender:
                            # No level is of two visitors.
                            self._meter.read()
                            self.sender = sound.sender
                        self._meter.add(sound.samples)
                        self.sound_received.notify_all(sound)
                    if _admits(self._visitors, sound, _RECOGNITION):
                        self.sound_to_recognise.notify_all(sound)

    async def _measure(self) -> None:
        while True:
            if self.level == SILENCE:
                await self.inlet.plugged()
            await self._clock.sleep_until(self._clock.now() + LEVEL_INTERVAL)
            self._set_level(self._meter.read())

    def _set_level(self, level: Level) -> None:
        if level != self.level:
            self.level = level
            self.level_changed.notify_all(level)

    def _on_withdrawn(self, visitor: Visitor, withdrawn: frozenset[Purpose]) -> None:
        """Forget what was heard of a visitor that does not consent to it any more."""
        if visitor.visitor_ref == self.sender and Purpose.LIVE in withdrawn:
            self._meter.read()
            self._set_level(SILENCE)


class Camera:
    """Camera that a body attends to. Its pictures are decoded while `inlet` has a subscriber.

    Args:
        visitors: those whose camera it may be; None for a camera that needs no consent, as the body's own.
    """

    def __init__(self, visitors: VisitorRegistry | None = None) -> None:
        self.inlet = VideoUplink("camera")
        self.keeping_ended: Listeners[str] = Listeners()
        """Listeners to the visitor_ref of each visitor of whom nothing may be kept any more."""
        self._visitors = visitors
        if visitors is not None:
            visitors.withdrawn.add(self._on_withdrawn)

    @property
    def is_connected(self) -> bool:
        """Whether an application sends a camera, suspended or not."""
        return self.inlet.stream_id is not None

    def attend(self, visitor: Visitor | None) -> None:
        """Read the camera of this visitor from now on, or none."""
        _attend(self.inlet, visitor)

    def may_recognise(self, picture: RawVideo) -> bool:
        """Tell whether something may be recognised in a picture, and announced, now."""
        return _admits(self._visitors, picture, _RECOGNITION)

    def may_keep(self, sender: str) -> bool:
        """Tell whether what is recognised of this visitor may be kept; of the body's own camera it may."""
        return self._visitors is None or self._visitors.may_keep(sender)

    def keeps_by_consent(self, sender: str) -> bool:
        """Tell whether what is kept of this visitor rests on a consent that it has stated, and ends with that."""
        return self._visitors is not None and self._visitors.states_consent(sender)

    def _on_withdrawn(self, visitor: Visitor, withdrawn: frozenset[Purpose]) -> None:
        if withdrawn & KEPT:
            self.keeping_ended.notify_all(visitor.visitor_ref)

    async def picture(self, timeout: float = 2.0) -> RawVideo:
        """Return the next picture that may be seen live.

        Raises:
            TimeoutError: none came within `timeout` seconds.
        """
        async with asyncio.timeout(timeout), self.inlet.subscribe(1) as pictures:
            while not _admits(self._visitors, picture := await pictures.get(), _LIVE):
                pass
            return picture


def _attend(inlet: AudioUplink | VideoUplink, visitor: Visitor | None) -> None:
    """Plug a visitor's device into an inlet, unless it is."""
    if visitor is None:
        if inlet.stream_id is not None:
            inlet.unplug(inlet.stream_id)
    elif inlet.stream_id != visitor.visitor_ref:
        inlet.plug(visitor.visitor_ref, visitor.source(inlet.kind, _USES, for_any=True))


def _admits(visitors: VisitorRegistry | None, item: RawAudio | RawVideo, purposes: frozenset[Purpose]) -> bool:
    return visitors is None or visitors.admits(item.sender, purposes, item.captured_at)
