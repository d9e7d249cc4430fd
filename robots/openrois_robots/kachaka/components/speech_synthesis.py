"""SpeechSynthesis: the robot speaks a text in its own voice (component 11)."""

from typing import Annotated

from kachaka_api.generated import kachaka_api_pb2 as pb2
from pydantic import Field

from openrois.adapter import BadParameter, OutOfResources, components, parameter
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.limits import SpeechSettings
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["SpeechSynthesis"]


class SpeechSynthesis(Acting, components.SpeechSynthesis, omit=("ssml_text", "language", "character")):
    """Speaks `speech_text`; `completed` comes when the robot says that it has.

    The API knows neither languages nor voices nor SSML. Speech never ends what the robot does: while it carries out
    another command, the robot decides whether it speaks at once or afterwards.

    Args:
        robot: the robot.
        commands: at it.
        api: of it.
        settings: what becomes of a text while the robot drives.
    """

    speech_text: Annotated[str, Field(max_length=4000)] | None = parameter(None)
    # Without it the robot keeps its own volume, which the standard's class does not know.
    volume: Annotated[int, Field(ge=0, le=100)] | None = parameter(  # type: ignore[assignment]
        None, description="per cent, in steps of 10; the robot's own unless set"
    )

    def __init__(self, robot: Kachaka, commands: Commands, api: KachakaApi, settings: SpeechSettings) -> None:
        super().__init__(robot, commands)
        self._api = api
        self._settings = settings

    async def start(self) -> None:
        """Speak to the end.

        Raises:
            BadParameter: there is no text.
            OutOfResources: the robot carries out another command, and `speech.while_driving` is `refuse`.
            ComponentFailed: the robot did not speak.
        """
        if not self.speech_text:
            raise BadParameter("speech_text is not set; set it before start")
        if self._settings.while_driving == "refuse":
            await self.robot.link.during(self._require_idle())
        if self.volume is not None:
            await self.robot.link.during(self._set_volume(self.volume))
        command = pb2.Command(speak_command=pb2.SpeakCommand(text=self.speech_text))
        await self.commands.perform(command, self.name, "speak", moves=False)

    async def _require_idle(self) -> None:
        state: pb2.GetCommandStateResponse = await self._api.call("GetCommandState")
        if state.command_id:
            raise OutOfResources(
                "the robot carries out another command, and is set not to be asked to speak meanwhile"
                " (speech.while_driving): speak when it has ended"
            )

    async def _set_volume(self, percent: int) -> None:
        request = pb2.SetSpeakerVolumeRequest(volume=round(percent / 10))
        response: pb2.SetSpeakerVolumeResponse = await self._api.call("SetSpeakerVolume", request)
        self.robot.texts.require_success(response.result, "set its volume")
