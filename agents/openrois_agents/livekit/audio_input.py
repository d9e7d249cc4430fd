"""The ears of an `AgentSession`: it hears the visitor whom a body attends to."""

from typing import Final

from livekit.agents.voice.io import AudioInput
from livekit.rtc import AudioFrame

from openrois_agents.voice.visitor_sound import VisitorSound

__all__ = ["VisitorAudioInput"]

_LABEL: Final = "OpenRoIS visitor"


class VisitorAudioInput(AudioInput):
    """Hears the visitor whom a body attends to; what comes while the session has its input off is dropped.

    Args:
        sound: open for as long as this is used, and read by nothing else.
    """

    def __init__(self, sound: VisitorSound) -> None:
        super().__init__(label=_LABEL)
        self._sound = sound
        self._is_on = False

    def on_attached(self) -> None:
        """Hear from now on."""
        self._is_on = True

    def on_detached(self) -> None:
        """Hear nothing from now on."""
        self._is_on = False

    async def __anext__(self) -> AudioFrame:
        while True:
            block = await anext(self._sound)
            if self._is_on:
                return AudioFrame(block.samples.tobytes(), self._sound.rate, 1, len(block.samples))
