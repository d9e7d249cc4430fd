"""SpeechSynthesis: the body speaks a text, and its mouth with it (component 11)."""

from typing import Annotated, Any

from pydantic import Field

from openrois.adapter import BadParameter, ComponentStatus, components, parameter
from openrois_body.speech.speaker import Speaker

__all__ = ["SpeechSynthesis"]

Speech = Annotated[str, Field(max_length=4000)]


class SpeechSynthesis(components.SpeechSynthesis):
    """Speaks the last set of `speech_text` and `ssml_text`; `completed` comes when the last sample was heard.

    Args:
        voice: speaks.
    """

    speech_text: Speech | None = parameter(None)
    ssml_text: Speech | None = parameter(None)
    volume: Annotated[int, Field(ge=0, le=100)] = parameter(50)

    def __init__(self, voice: Speaker) -> None:
        super().__init__()
        self._voice = voice

    def condition(self) -> ComponentStatus:
        """Return READY where texts can be spoken, else ERROR."""
        return ComponentStatus.READY if self._voice.available()[0] else ComponentStatus.ERROR

    def problem(self) -> str:
        """Return why texts cannot be spoken, or what to install."""
        return self._voice.available()[1]

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Let one text replace the other, also where it is empty; refuse two at once."""
        plain, marked_up = changes.get("speech_text"), changes.get("ssml_text")
        if plain and marked_up:
            raise BadParameter("speech_text and ssml_text cannot be set together; set one of them")
        if plain is not None and not marked_up:
            return {**changes, "ssml_text": None}
        if marked_up is not None:
            return {**changes, "speech_text": None}
        return changes

    async def synthesizable_languages(self) -> tuple[str, ...]:
        """Return the languages it speaks, as BCP 47 tags."""
        return tuple(await self._voice.languages())

    async def available_voices(self) -> tuple[str, ...]:
        """Return the names that `character` takes."""
        return tuple(await self._voice.characters())

    async def start(self) -> None:
        """Speak to the end."""
        text = self.speech_text or self.ssml_text
        if not text:
            raise BadParameter("neither speech_text nor ssml_text is set; set one of them before start")
        await self._voice.say(
            text,
            ssml=not self.speech_text,
            language=self.language,
            character=self.character,
            volume=self.volume,
        )

    async def stop(self) -> None:
        """Fall silent; why `start` ends says at which word."""
        self._voice.interrupt("the speech was stopped")
        await self._voice.silent()

    async def suspend(self) -> None:
        """Fall silent until `resume`, in the middle of a word too; `start` goes on to run."""
        self._voice.pause()

    async def resume(self) -> None:
        """Go on where it was suspended."""
        self._voice.go_on()
