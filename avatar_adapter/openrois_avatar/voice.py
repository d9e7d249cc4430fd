"""The avatar's voice: a text becomes sound, and the mouth moves with the sound."""

from collections.abc import Sequence
from typing import Protocol

from openrois.aio.listeners import Listeners
from openrois.errors import BadParameter, ComponentFailed, OutOfResources
from openrois_avatar.audience import Audience
from openrois_avatar.body import Body
from openrois_avatar.sound import AvatarSound, SoundBusy
from openrois_avatar.speech.synthesizer import Speech, SpeechRefused, SpeechUnavailable
from openrois_avatar.utterance import Progress, Utterance

__all__ = ["DEFAULT_CHARACTER", "Synthesis", "Voice"]

DEFAULT_CHARACTER = "default"
"""The character whose voice is the language's own."""


class Synthesis(Protocol):
    """What makes speech of text; see `openrois_avatar.speech.synthesizer.Synthesizer`."""

    def available(self) -> tuple[bool, str]:
        """Whether it is installed; if not, what to do."""
        ...

    async def languages(self) -> Sequence[str]:
        """The languages it speaks; raises SpeechUnavailable."""
        ...

    async def voices(self) -> Sequence[str]:
        """The voices it has; raises SpeechUnavailable."""
        ...

    async def synthesize(
        self, text: str, *, language: str = ..., voice: str | None = ..., volume: int = ..., ssml: bool = ...
    ) -> Speech:
        """Make speech of a text; raises SpeechRefused and SpeechUnavailable."""
        ...


class Voice:
    """Speaks through the avatar's sound, and moves the mouth of its body with it.

    Args:
        synthesizer: makes speech of text.
        sound: what is heard of the avatar.
        body: whose mouth moves.
    """

    def __init__(self, synthesizer: Synthesis, sound: AvatarSound, body: Body) -> None:
        self.audience = Audience()
        """Those who hear it; nobody at first."""
        self.progress: Listeners[Progress] = Listeners()
        """Are told each word when it is heard, each mark, and how a speech ended."""
        self._synthesizer = synthesizer
        self._sound = sound
        self._body = body
        self._utterances: list[Utterance] = []

    def available(self) -> tuple[bool, str]:
        """Return whether speech can be made here, and if not, what to install."""
        return self._synthesizer.available()

    async def languages(self) -> Sequence[str]:
        """Return the languages it speaks, as BCP 47 tags.

        Raises:
            ComponentFailed: it cannot speak now.
        """
        try:
            return await self._synthesizer.languages()
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    async def characters(self) -> Sequence[str]:
        """Return the characters that `say` takes, the default one first.

        Raises:
            ComponentFailed: it cannot speak now.
        """
        try:
            return (DEFAULT_CHARACTER, *await self._synthesizer.voices())
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error

    async def say(self, text: str, *, ssml: bool, language: str, character: str, volume: int) -> None:
        """Speak a text until its last sample was heard; cancelling it cuts voice and mouth within 20 ms.

        Args:
            text: what to say, at most 4,000 characters.
            ssml: whether `text` is SSML.
            language: a BCP 47 tag.
            character: one of `characters()`.
            volume: 0 to 100.

        Raises:
            Aborted: it was interrupted; the sentence says why, and at which word.
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: nothing can be spoken now.
            OutOfResources: too much waits to be spoken already.
        """
        voice = None if character == DEFAULT_CHARACTER else character
        utterance = Utterance(self._sound, self._body, self.audience, self.progress.tell, text, is_ssml=ssml)
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
        """Break off all that is said and is to be said: voice and mouth are cut within a block of sound (20 ms).

        Args:
            why: how the sentence begins that `say` fails with; what follows says at which word.
        """
        for utterance in self._utterances:
            utterance.cut(why)

    async def silent(self) -> None:
        """Wait until `say` has ended for all that was begun; after `interrupt` that takes no time."""
        for utterance in tuple(self._utterances):
            if utterance.begun:
                await utterance.over.wait()

    def pause(self) -> None:
        """Fall silent within a block of sound, until `go_on`."""
        for utterance in self._utterances:
            utterance.pause()

    def go_on(self) -> None:
        """Go on where it was paused, in the middle of a word too."""
        for utterance in self._utterances:
            utterance.go_on()
