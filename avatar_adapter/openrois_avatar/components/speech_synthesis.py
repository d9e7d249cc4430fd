"""SpeechSynthesis: the avatar speaks a text, and its mouth with it (component 11)."""

from typing import Final

from openrois.component import Component, command, parameter_profile, query
from openrois.errors import BadParameter
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Result
from openrois.types.profiles import CommandMessageProfile, QueryMessageProfile
from openrois.types.values import encode_list
from openrois_avatar.components.profiles import component_profile
from openrois_avatar.voice import Voice

__all__ = ["SpeechSynthesis"]

_MAX_TEXT: Final = 4000


class SpeechSynthesis(Component):
    """Speaks `speech_text` or `ssml_text`, whichever was set last; `completed` comes at the last sample.

    Args:
        voice: what speaks.
    """

    def __init__(self, voice: Voice) -> None:
        super().__init__(
            component_profile(
                "SpeechSynthesis",
                ComponentFunction.ACTUATION,
                commands=(CommandMessageProfile(name="start"), CommandMessageProfile(name="stop")),
                queries=(
                    QueryMessageProfile(
                        name="synthesizable_languages", results=(parameter_profile("languages", "string[]"),)
                    ),
                    QueryMessageProfile(
                        name="available_voices", results=(parameter_profile("characters", "string[]"),)
                    ),
                ),
                parameters=(
                    parameter_profile("speech_text", "string"),
                    parameter_profile("ssml_text", "string"),
                    parameter_profile("volume", "int", "50", "0 to 100"),
                    parameter_profile("language", "string", "en"),
                    parameter_profile("character", "string", "default"),
                ),
            )
        )
        self._voice = voice

    def condition(self) -> ComponentStatus:
        """READY where speech synthesis is installed, else ERROR."""
        return ComponentStatus.READY if self._voice.available()[0] else ComponentStatus.ERROR

    def accept_parameters(self, values: dict[str, str]) -> dict[str, str]:
        """Let one text replace the other; refuse two at once, a text too long, and a volume beyond 0 to 100."""
        if values.get("speech_text") and values.get("ssml_text"):
            raise BadParameter("speech_text or ssml_text, not both")
        for name in ("speech_text", "ssml_text"):
            if len(values.get(name, "")) > _MAX_TEXT:
                raise BadParameter(f"{name} has at most {_MAX_TEXT} characters")
        if not 0 <= int(values.get("volume", "50")) <= 100:
            raise BadParameter("volume goes from 0 to 100")
        if values.get("speech_text"):
            return {**values, "ssml_text": ""}
        if values.get("ssml_text"):
            return {**values, "speech_text": ""}
        return values

    @query("synthesizable_languages")
    async def synthesizable_languages(self) -> tuple[Result, ...]:
        """Return the languages it speaks, as BCP 47 tags."""
        languages = await self._voice.languages()
        return (Result(name="languages", data_type_ref="string[]", value=encode_list(languages)),)

    @query("available_voices")
    async def available_voices(self) -> tuple[Result, ...]:
        """Return the names that `character` takes."""
        characters = await self._voice.characters()
        return (Result(name="characters", data_type_ref="string[]", value=encode_list(characters)),)

    @command("start")
    async def start(self, _arguments: dict[str, str]) -> tuple[Result, ...]:
        """Speak to the end."""
        text, ssml = self.parameters["speech_text"], self.parameters["ssml_text"]
        if not text and not ssml:
            raise BadParameter("set speech_text or ssml_text first")
        await self._voice.say(
            text or ssml,
            ssml=not text,
            language=self.parameters["language"],
            character=self.parameters["character"],
            volume=int(self.parameters["volume"]),
        )
        return ()
