"""Hearing: what is understood of the operator while the words come, and what was heard last. A component of our own."""

from datetime import UTC, datetime

from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import ComponentStatus, Payload, components, event, query
from openrois_avatar.components.sensing import Sense
from openrois_avatar.hearing.ear import Ear
from openrois_avatar.hearing.hearing import Hearing as Hears
from openrois_avatar.hearing.recognition import Recognition

__all__ = ["Hearing"]


class LastHeard(Payload):
    """What was recognised last, and when it ended; an empty text if there was nothing yet."""

    text: str
    timestamp: datetime | None = None


class MicrophoneResult(Payload):
    """What is known of the microphone: different channels, 0 before there was a sound; whether somebody speaks."""

    channels: int
    speaking: bool


class Hearing(Sense, components.BasicComponent, authority="OpenRoIS", function="sensing"):
    """Shows what SpeechRecognition understands, while the words come; the grammar and language are those set there.

    Args:
        ear: what is heard.
        hears: tells who speaks.
        recognition: writes down what is said.
        clock: the media clock.
    """

    def __init__(self, ear: Ear, hears: Hears, recognition: Recognition, clock: MediaClock) -> None:
        super().__init__()
        self._ear = ear
        self._hears = hears
        self._recognition = recognition
        self._clock = clock
        self._last = LastHeard(text="")
        recognition.guessed.add(self._guess)
        recognition.recognized.add(self._tell)
        self.activity.while_working(self._recognition.want)

    def condition(self) -> ComponentStatus:
        """READY unless nothing can be recognised now."""
        return ComponentStatus.ERROR if self._recognition.failure else ComponentStatus.READY

    @event
    def heard(self, text: str, final: bool, timestamp: datetime | None = None) -> None:
        """What is understood now, or at last.

        Args:
            text: words; empty where what seemed to be words were none
            final: whether it stays so: it is the first candidate of SpeechRecognition's event
            timestamp: when it ended, where it is final
        """

    @query
    async def last_heard(self) -> LastHeard:
        """Return what was recognised last."""
        return self._last

    @query
    async def microphone(self) -> MicrophoneResult:
        """Return what is known of the microphone; speech is known of while somebody listens for it."""
        return MicrophoneResult(channels=self._ear.channels, speaking=self._hears.speaking)

    def _guess(self, text: str) -> None:
        if self.activity.works:
            self.heard(text, False)

    def _tell(self, candidates: tuple[str, ...], at: float) -> None:
        moment = datetime.fromtimestamp(wall_at(self._clock, at), UTC)
        self._last = LastHeard(text=candidates[0], timestamp=moment)
        if self.activity.works:
            self.heard(candidates[0], True, moment)
