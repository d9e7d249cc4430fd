"""The avatar's voice: a text becomes sound, and the mouth moves with the sound."""

import secrets
from collections.abc import Sequence
from typing import Protocol

from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources
from openrois_avatar.body import Body
from openrois_avatar.sound import AvatarSound, SoundBusy
from openrois_avatar.speech.synthesizer import Speech, SpeechRefused, SpeechUnavailable

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
        self._synthesizer = synthesizer
        self._sound = sound
        self._body = body

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
        """Speak a text to its last sample; cancelling it cuts voice and mouth within a block of sound (20 ms).

        Args:
            text: what to say, at most 4,000 characters.
            ssml: whether `text` is SSML.
            language: a BCP 47 tag.
            character: one of `characters()`.
            volume: 0 to 100.

        Raises:
            BadParameter: this text, language or character cannot be spoken.
            ComponentFailed: nothing can be spoken now.
            OutOfResources: too much waits to be spoken already.
        """
        voice = None if character == DEFAULT_CHARACTER else character
        try:
            speech = await self._synthesizer.synthesize(text, language=language, voice=voice, volume=volume, ssml=ssml)
            await self._play(speech)
        except SpeechRefused as error:
            raise BadParameter(str(error)) from error
        except SpeechUnavailable as error:
            raise ComponentFailed(str(error)) from error
        except SoundBusy as error:
            raise OutOfResources(str(error)) from error

    async def _play(self, speech: Speech) -> None:
        playback = self._sound.play(speech.samples)
        self._body.speak(speech.mouth(secrets.token_hex(8), playback.start_ns))
        played = False
        try:
            played = await playback.ended()
        finally:
            if not played:
                playback.stop()
                self._body.silence()
        if not played:
            raise Aborted("the speech was cut off")
