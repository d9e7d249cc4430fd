"""Hearing: partial and final recognition of the operator's speech. A component of OpenRoIS."""

from datetime import UTC, datetime

from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import ComponentStatus, Payload, components, event, query
from openrois_body.components.sensing import Sense
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.speech_detector import SpeechDetector

__all__ = ["Hearing"]


class LastHeard(Payload):
    """The last recognised text and when it ended; an empty text before the first, and when consent is withdrawn."""

    text: str
    timestamp: datetime | None = None


class MicrophoneResult(Payload):
    """The microphone: number of different channels, 0 before the first sound; whether the operator speaks."""

    channels: int
    speaking: bool


class RecognizerResult(Payload):
    """Where the sound of speech is sent to be recognised, as `https://host`; empty where it stays with the adapter.

    It is sent only while `allowed`: those who speak have agreed, or it stays with the adapter. A visitor's is sent only
    where that one consents to it, too.
    """

    sent_to: str
    allowed: bool


class Hearing(Sense, components.BasicComponent, authority="OpenRoIS", function="sensing"):
    """Announces partial results of SpeechRecognition, with the grammar and language that are set there.

    Args:
        ear: the microphone's sound.
        speech: tells when the operator speaks.
        recognition: recognises what is said.
        clock: the media clock.
    """

    def __init__(self, ear: Ear, speech: SpeechDetector, recognition: Recognition, clock: MediaClock) -> None:
        super().__init__()
        self._ear = ear
        self._speech = speech
        self._recognition = recognition
        self._clock = clock
        self._last = LastHeard(text="")
        self._last_sender = ""
        recognition.guessed.add(self._on_guessed)
        recognition.recognized.add(self._on_recognized)
        self.activity.while_working(self._recognition.want)

    def forget_words(self, sender: str) -> None:
        """Forget the last words, if this visitor said them."""
        if sender == self._last_sender:
            self._last = LastHeard(text="")

    def condition(self) -> ComponentStatus:
        """Return READY unless speech recognition fails now."""
        return ComponentStatus.ERROR if self._recognition.failure else ComponentStatus.READY

    def problem(self) -> str:
        """Return why speech is not recognised now."""
        return self._recognition.failure

    @event
    def heard(self, text: str, final: bool, timestamp: datetime | None = None, visitor_ref: str | None = None) -> None:
        """A partial or final result.

        Args:
            text: words; empty where what seemed to be words were none, or speech was none of the grammar's sentences
            final: whether it stays so: it is the first candidate of SpeechRecognition's event, if it has words
            timestamp: when it ended, where it is final
            visitor_ref: who said it, where visitors are told apart
        """

    @query
    async def last_heard(self) -> LastHeard:
        """Return the last recognised text."""
        return self._last

    @query
    async def microphone(self) -> MicrophoneResult:
        """Return the state of the microphone; speech is detected only while a component needs it."""
        return MicrophoneResult(channels=self._ear.channels, speaking=self._speech.speaking)

    @query
    async def recognizer(self) -> RecognizerResult:
        """Return where speech is recognised."""
        return RecognizerResult(sent_to=self._recognition.destination, allowed=not self._recognition.withheld)

    def _on_guessed(self, text: str, sender: str) -> None:
        if self.activity.works:
            self.visitor_ref = sender
            self.heard(text, False, None, sender or None)

    def _on_recognized(self, candidates: tuple[str, ...], at: float, sender: str) -> None:
        moment = datetime.fromtimestamp(wall_at(self._clock, at), UTC)
        if candidates[0]:
            self._last, self._last_sender = LastHeard(text=candidates[0], timestamp=moment), sender
        if self.activity.works:
            self.visitor_ref = sender
            self.heard(candidates[0], True, moment, sender or None)
