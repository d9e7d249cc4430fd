"""The voice: texts are synthesized and played, and the mouth moves with the sound."""

from collections.abc import Sequence
from typing import Protocol

from openrois.aio.listeners import Listeners
from openrois.errors import BadParameter, ComponentFailed, OutOfResources
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound, SoundBusy
from openrois_body.speech.playout_delay import PlayoutDelay
from openrois_body.speech.synthesizer import Speech, SpeechRefused, SpeechUnavailable
from openrois_body.speech.utterance import Progress, Utterance

__all__ = ["DEFAULT_CHARACTER", "Synthesis", "Voice"]

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


class Voice:
    """Speaks through the body's sound, and moves its mouth.

    Args:
        synthesizer: synthesizes texts.
        sound: the body's sound.
        body: moves the mouth.
    """

    def __init__(self, synthesizer: Synthesis, sound: BodySound, body: Body) -> None:
        self.playout_delay = PlayoutDelay()
        """The playout delay of the viewers that hear it."""
        self.progress: Listeners[Progress] = Listeners()
        """Called with each word when the viewers hear it, each mark, and the end of each speech."""
        self._synthesizer = synthesizer
        self._sound = sound
        self._body = body
        self._utterances: list[Utterance] = []

    def available(self) -> tuple[bool, str]:
        """Return whether speech synthesis is installed, and if not, what to install."""
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

    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until the viewers heard its last sample; cancelling this cuts voice and mouth within 20 ms.

        Args:
            text: at most 4,000 characters.
            ssml: whether `text` is SSML.
            language: a BCP 47 tag.
            character: one of `characters()`.
            volume: 0 to 100.

        Raises:
            Aborted: it was interrupted; the sentence says why, and at which word.
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: speech synthesis is not available now.
            OutOfResources: too many speeches wait already.
        """
        voice = None if character == DEFAULT_CHARACTER else character
        utterance = Utterance(self._sound, self._body, self.playout_delay, self.progress.notify_all, text, is_ssml=ssml)
        self._utterances.append(utterance)
        try:
            speech = await self._synthesizer.synthesize(text, language=language, voice=voice, volume=volume, ssml=ssml)
            await utterance.play(speech)
        except SpeechRefused as error:
            raise BadParameter(str(error)) from error
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error
        except SoundBusy as error:
            raise OutOfResources(str(error)) from error
        finally:
            self._utterances.remove(utterance)

    def interrupt(self, why: str) -> None:
        """Cut off all speeches, also those that wait: voice and mouth stop within a block of sound (20 ms).

        Args:
            why: begins the sentence that `say` fails with; the word follows.
        """
        for utterance in self._utterances:
            utterance.cut(why)

    async def silent(self) -> None:
        """Wait until every `say` that has begun has ended; after `interrupt` that takes no time."""
        for utterance in tuple(self._utterances):
            if utterance.begun:
                await utterance.over.wait()

    def pause(self) -> None:
        """Fall silent within a block of sound, until `go_on`."""
        for utterance in self._utterances:
            utterance.pause()

    def go_on(self) -> None:
        """Resume where it was paused, in the middle of a word too."""
        for utterance in self._utterances:
            utterance.go_on()
