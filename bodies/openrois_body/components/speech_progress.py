"""SpeechProgress: the body's speech word by word, where its sound is late, and its interruption (barge-in)."""

from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Protocol

from openrois.adapter import Component, ComponentStatus, event, parameter, query
from openrois.aio.listeners import Listeners
from openrois.types.codes import CompletedStatus
from openrois_body.speech.progress import (
    MarkReached,
    Progress,
    SpeechBegan,
    SpeechEnded,
    SpeechStarved,
    WordSpoken,
)
from openrois_body.speech.voice import Voice

__all__ = ["Attention", "SpeechProgress"]


class Attention(Protocol):
    """Detects speech to the body while it is attended to; `openrois_body.hearing.speech_detector` implements it."""

    speech_began: Listeners[float]
    """Called with the time when speech began."""

    def attend(self) -> Callable[[], None]:
        """Detect speech from now on; return a function that ends that."""
        ...


class SpeechProgress(Component, authority="OpenRoIS", function="actuation", part="voice"):
    """Announces the progress of speech, of texts and of streams. A component of OpenRoIS: the standard's has no events.

    An actuation, so that only the application that has bound it sets `barge_in`; every application gets its events.

    Args:
        voice: speaks.
        attention: detects speech to the body.
    """

    barge_in: bool = parameter(False, description="whether speech stops when a person speaks to the body")

    def __init__(self, voice: Voice, attention: Attention) -> None:
        super().__init__()
        self._voice = voice
        self._attention = attention
        self._desert: Callable[[], None] | None = None
        voice.progress.add(self._progressed)
        attention.speech_began.add(self._spoken_to)

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Detect speech as long as `barge_in` is set."""
        wanted = changes.get("barge_in")
        if wanted and self._desert is None:
            self._desert = self._attention.attend()
        if wanted is False and self._desert is not None:
            self._desert()
            self._desert = None
        return changes

    def condition(self) -> ComponentStatus:
        """Return READY where speech synthesis is installed, else ERROR."""
        return ComponentStatus.READY if self._voice.available()[0] else ComponentStatus.ERROR

    @event
    def speech_began(self, speech_id: str, text: str, is_ssml: bool, began_at: datetime) -> None:
        """The viewers hear the first sound of a text or a stream: captions show it.

        Args:
            speech_id: of what is spoken
            text: speech_text or ssml_text, as it was set; of a stream the words that it began with
            is_ssml: whether it is SSML
            began_at: when they hear it
        """

    @event
    def word_spoken(self, speech_id: str, word: str, position: int, length: int, spoken_at: datetime) -> None:
        """The viewers hear a word. Words that are said in one breath may be told as the first of them.

        Args:
            speech_id: of the text that is spoken, the same in all events about it
            word: as it stands in the text
            position: of its first character in speech_text or ssml_text, from 0 on, in Unicode code points; in a stream
                in all of its words, with a space between them
            length: of the word, likewise
            spoken_at: when they hear it
        """

    @event
    def mark_reached(self, speech_id: str, mark: str, reached_at: datetime) -> None:
        """The viewers hear what follows a mark of the SSML.

        Args:
            speech_id: of the text that is spoken
            mark: its name
            reached_at: when they hear it
        """

    @event
    def speech_starved(self, speech_id: str, heard_ms: int, starved_at: datetime) -> None:
        """The viewers hear silence in the middle of a speech: its sound comes too late. Told once each time.

        Args:
            speech_id: of the speech
            heard_ms: of its sound so far, in milliseconds
            starved_at: when they hear the silence begin
        """

    @event
    def speech_ended(
        self,
        speech_id: str,
        status: CompletedStatus,
        ended_at: datetime,
        reason: str | None = None,
        word: str | None = None,
        position: int | None = None,
        heard_ms: int | None = None,
    ) -> None:
        """Nothing more of a text or stream is heard.

        Args:
            speech_id: of the text or stream
            status: OK, or ABORT if it was stopped or interrupted
            ended_at: when it ended
            reason: why it did not come to its end
            word: the last one that was begun
            position: of that word
            heard_ms: of its sound, in milliseconds
        """

    @query(result="sent_to")
    async def synthesizer(self) -> str:
        """Return where texts are sent to be spoken, as `https://host`; empty where they stay with the adapter."""
        return self._voice.destination

    def _spoken_to(self, _at: float) -> None:
        if self.barge_in:
            self._voice.interrupt("a person spoke, and the speech stopped")

    def _progressed(self, progress: Progress) -> None:
        at = datetime.fromtimestamp(progress.at, UTC)
        match progress:
            case SpeechBegan(speech_id, text, is_ssml):
                self.speech_began(speech_id, text, is_ssml, at)
            case WordSpoken(speech_id, word, position):
                self.word_spoken(speech_id, word, position, len(word), at)
            case MarkReached(speech_id, mark):
                self.mark_reached(speech_id, mark, at)
            case SpeechStarved(speech_id, heard_ms):
                self.speech_starved(speech_id, heard_ms, at)
            case SpeechEnded(speech_id, status, reason, last):
                at_word, since = (last.text, last.position) if last else (None, None)
                self.speech_ended(speech_id, status, at, reason or None, at_word, since, progress.heard_ms)
