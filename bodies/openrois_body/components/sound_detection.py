"""SoundDetection: whether there is a sound at the operator's microphone (component 7)."""

from collections.abc import Callable
from datetime import UTC, datetime

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawAudio

from openrois.adapter import components
from openrois_body.components.sensing import Sense
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.noise_floor import Presence
from openrois_body.sensing.changes import Numbers

__all__ = ["SoundDetection"]


class SoundDetection(Sense, components.SoundDetection):
    """Announces 1 when a sound rises above the background, 0 when it has ended: sources are not told apart.

    Args:
        ear: the microphone's sound.
        clock: the media clock.
    """

    def __init__(self, ear: Ear, clock: MediaClock) -> None:
        super().__init__()
        self._ear = ear
        self._clock = clock
        self._presence, self._numbers = Presence(), Numbers()
        self.activity.while_working(self._listen)
        ear.forgotten.add(self._forget)

    def _listen(self) -> Callable[[], None]:
        self._presence = Presence()
        self._numbers.begin()
        if not self._ear.sounding:
            # The microphone may have ended in a pause. Its silence would count as background, so it is left out.
            self._announce_number(0, self._clock.now())
        return self._ear.listen(self._on_sound)

    def _forget(self) -> None:
        if self.activity.works:
            self._presence = Presence()
            self._announce_number(0, self._clock.now())

    def _on_sound(self, sound: RawAudio) -> None:
        self._announce_number(self._presence.add(sound.samples), sound.captured_at)

    def _announce_number(self, number: int, moment: float) -> None:
        if self._numbers.is_news(number):
            self.visitor_ref = self._ear.sender
            self.sound_detected(number, datetime.fromtimestamp(wall_at(self._clock, moment), UTC))
