"""What speaks texts, wherever they are heard: its languages and characters, and what a text becomes."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Protocol

from openrois.errors import BadParameter, ComponentFailed
from openrois_body.speech.synthesizer import Speech, SpeechRefused, SpeechUnavailable

__all__ = ["DEFAULT_CHARACTER", "Speaker", "Synthesis"]

DEFAULT_CHARACTER = "default"
"""The character with the language's own voice."""


class Synthesis(Protocol):
    """Speech synthesis; see `openrois_body.speech.synthesizer.Synthesizer`."""

    def available(self) -> tuple[bool, str]:
        """Return whether it is installed; if not, what to do."""
        ...

    async def languages(self) -> Sequence[str]:
        """Return the available languages; raises SpeechUnavailable."""
        ...

    async def voices(self) -> Sequence[str]:
        """Return the available voices; raises SpeechUnavailable."""
        ...

    async def synthesize(
        self, text: str, *, language: str = ..., voice: str | None = ..., volume: int = ..., ssml: bool = ...
    ) -> Speech:
        """Synthesize a text; raises SpeechRefused and SpeechUnavailable."""
        ...


class Speaker(ABC):
    """Speaks texts.

    Args:
        synthesizer: synthesizes texts.
    """

    def __init__(self, synthesizer: Synthesis) -> None:
        self._synthesizer = synthesizer

    def available(self) -> tuple[bool, str]:
        """Return whether texts can be spoken now; if not, why, or what to install."""
        return self._synthesizer.available()

    async def languages(self) -> Sequence[str]:
        """Return the available languages, as BCP 47 tags.

        Raises:
            ComponentFailed: speech synthesis is not available now.
        """
        try:
            return await self._synthesizer.languages()
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    async def characters(self) -> Sequence[str]:
        """Return the characters that `say` takes, the default one first.

        Raises:
            ComponentFailed: speech synthesis is not available now.
        """
        try:
            return (DEFAULT_CHARACTER, *await self._synthesizer.voices())
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    async def make_speech(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> Speech:
        """Return a text as sound.

        Raises:
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: speech synthesis is not available now.
        """
        voice = None if character == DEFAULT_CHARACTER else character
        try:
            return await self._synthesizer.synthesize(text, language=language, voice=voice, volume=volume, ssml=ssml)
        except SpeechRefused as error:
            raise BadParameter(str(error)) from error
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    @abstractmethod
    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until its last sample was heard; cancelling this cuts it off.

        Args:
            text: at most 4,000 characters.
            ssml: whether `text` is SSML.
            language: a BCP 47 tag.
            character: one of `characters()`.
            volume: 0 to 100.

        Raises:
            Aborted: it was interrupted; the sentence says why, and at which word.
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: it cannot be spoken now.
            OutOfResources: too many speeches wait already.
        """

    @abstractmethod
    def interrupt(self, why: str) -> None:
        """Cut off all speeches, also those that wait.

        Args:
            why: begins the sentence that `say` fails with; the word follows.
        """

    @abstractmethod
    async def silent(self) -> None:
        """Wait until every `say` that has begun has ended; after `interrupt` that takes no time."""

    @abstractmethod
    def pause(self) -> None:
        """Fall silent until `go_on`."""

    @abstractmethod
    def go_on(self) -> None:
        """Resume where it was paused, in the middle of a word too."""
