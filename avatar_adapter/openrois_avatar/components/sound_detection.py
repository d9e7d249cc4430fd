"""SoundDetection: whether there is a sound at the operator's microphone (component 7)."""

from collections.abc import Callable
from datetime import UTC, datetime

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawAudio

from openrois.adapter import components
from openrois_avatar.components.sensing import Sense
from openrois_avatar.hearing.ear import Ear
from openrois_avatar.hearing.presence import Presence
from openrois_avatar.sensing.changes import Numbers

__all__ = ["SoundDetection"]


class SoundDetection(Sense, components.SoundDetection):
    """Tells 1 when a sound rises above the background, 0 when it has ended: sources are not told apart.

    Args:
        ear: what is heard.
        clock: the media clock.
    """

    def __init__(self, ear: Ear, clock: MediaClock) -> None:
        super().__init__()
        self._ear = ear
        self._clock = clock
        self._presence, self._numbers = Presence(), Numbers()
        self.activity.while_working(self._listen)

    def _listen(self) -> Callable[[], None]:
        self._presence = Presence()
        self._numbers.begin()
        if not self._ear.sounding:
            # The microphone may have ended in a pause. Its silence would count as background: that is not to be heard.
            self._tell(0, self._clock.now())
        return self._ear.listen(self._hear)

    def _hear(self, sound: RawAudio) -> None:
        self._tell(self._presence.add(sound.samples), sound.captured_at)

    def _tell(self, number: int, moment: float) -> None:
        if self._numbers.tells(number):
            self.sound_detected(number, datetime.fromtimestamp(wall_at(self._clock, moment), UTC))
