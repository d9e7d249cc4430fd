"""SpeechStream: the body speaks sound that an application sends. A component of OpenRoIS."""

from openrois.adapter import Component, ComponentStatus, Payload, command, query
from openrois_body.speech.speech_control import SpeechControl

__all__ = ["SpeechStream"]


class StreamingResult(Payload):
    """Speeches that are played or wait, and counts since the adapter began."""

    speeches: int
    taken: int
    dropped: int
    refused: int
    malformed: int


class SpeechStream(Component, authority="OpenRoIS", function="actuation", part="voice"):
    """Lets the application that has bound it speak by sound, which it sends over the data channel `speech`.

    Args:
        speech_control: plays it.
    """

    def __init__(self, speech_control: SpeechControl) -> None:
        super().__init__()
        self._speech_control = speech_control

    def condition(self) -> ComponentStatus:
        """Return READY: sound needs no synthesizer, and is heard without a game engine."""
        return ComponentStatus.READY

    @command
    async def stop(self) -> None:
        """Cut off what is spoken, and what waits; a speech that begins later is spoken."""
        self._speech_control.interrupt("the speech was stopped")

    @query
    async def streaming(self) -> StreamingResult:
        """Return the number of speeches, and counts of frames and messages."""
        figures = self._speech_control.figures
        return StreamingResult(
            speeches=self._speech_control.streams,
            taken=figures.taken,
            dropped=figures.dropped,
            refused=figures.refused,
            malformed=figures.malformed,
        )
