"""What speaks texts, wherever they are heard: its languages and characters, and what a text becomes."""

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

from openrois.errors import BadParameter, ComponentFailed
from openrois_body.speech.contract import (
    Speech,
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechSynthesizer,
    SpeechUnavailable,
    collect_speech,
)

__all__ = ["DEFAULT_CHARACTER", "Speaker"]

DEFAULT_CHARACTER = "default"
"""The character with the language's own voice."""


class Speaker(ABC):
    """Speaks texts.

    Args:
        synthesizer: synthesizes texts.
    """

    def __init__(self, synthesizer: SpeechSynthesizer) -> None:
        self._synthesizer = synthesizer

    @property
    def destination(self) -> str:
        """Where texts are sent, as `https://host`; empty where they stay on this machine."""
        return self._synthesizer.destination

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

    @asynccontextmanager
    async def open_speech(
        self, text: str, *, ssml: bool, language: str, character: str, volume: int
    ) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        """Make a text into sound; its pieces come as they are made, while the context lasts.

        Raises:
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: speech synthesis is not available now, or fails in the middle.
        """
        voice = None if character == DEFAULT_CHARACTER else character
        try:
            async with self._synthesizer.speak(SpeechRequest(text, ssml, language, voice, volume)) as chunks:
                yield chunks
        except SpeechRefused as error:
            raise BadParameter(str(error)) from error
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    async def make_speech(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> Speech:
        """Return a text as sound, when all of it is made; raises as `open_speech`."""
        opened = self.open_speech(text, ssml=ssml, language=language, character=character, volume=volume)
        async with opened as chunks:
            return await collect_speech(chunks)

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
