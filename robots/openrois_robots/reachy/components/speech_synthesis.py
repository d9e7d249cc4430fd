"""SpeechSynthesis: our voice on the robot's loudspeaker (component 11)."""

from openrois_body.components import speech_synthesis
from openrois_body.speech.speaker import Speaker

from openrois.adapter import ComponentStatus
from openrois_robots.reachy.robot import Reachy

__all__ = ["SpeechSynthesis"]


class SpeechSynthesis(speech_synthesis.SpeechSynthesis):
    """Speaks on the robot, which does not tell when a sound is over: `completed` comes when it has to be.

    Args:
        voice: speaks.
        robot: the robot.
    """

    def __init__(self, voice: Speaker, robot: Reachy) -> None:
        super().__init__(voice)
        self._robot = robot

    def condition(self) -> ComponentStatus:
        """Return the status of the link; ERROR where nothing would be heard."""
        return super().condition() if self._robot.link.is_up else self._robot.link.status

    def problem(self) -> str:
        """Return why nothing would be heard."""
        return self._robot.link.problem or super().problem()
