"""The application's end of the data channels over which it speaks by sound."""

from collections.abc import Callable

from aiortc import RTCDataChannel, RTCPeerConnection

from openrois_streaming.peer.input_channels import CONTROL_ID, SPEECH_ID, is_open

__all__ = ["SpeechChannel"]


class SpeechChannel:
    """Channels `speech` and `control` of one peer connection.

    Args:
        on_told: called with each message of the body over `speech`.
        on_change: called when the channels open, or one of them closes.
    """

    def __init__(self, on_told: Callable[[str], None], on_change: Callable[[], None]) -> None:
        self._on_told = on_told
        self._on_change = on_change
        self._control: RTCDataChannel | None = None
        self._speech: RTCDataChannel | None = None

    def make(self, connection: RTCPeerConnection) -> None:
        """Make the channels on a peer connection that was offered an application section."""
        self._control = connection.createDataChannel("control", negotiated=True, id=CONTROL_ID)
        self._speech = connection.createDataChannel("speech", negotiated=True, id=SPEECH_ID)
        self._speech.on("message", self._receive)
        for channel in (self._control, self._speech):
            channel.on("open", self._on_change)
            channel.on("close", self._on_change)

    @property
    def is_open(self) -> bool:
        """Whether both channels are open."""
        return all(channel is not None and is_open(channel) for channel in (self._control, self._speech))

    def speak(self, data: str | bytes) -> None:
        """Send a frame or a message over `speech`; it is lost if the channels are not open."""
        if self._speech is not None and is_open(self._speech):
            self._speech.send(data)

    def overtake(self, text: str) -> None:
        """Send a message over `control`, past all sound; it is lost if the channels are not open."""
        if self._control is not None and is_open(self._control):
            self._control.send(text)

    def _receive(self, data: str | bytes) -> None:
        if isinstance(data, str):
            self._on_told(data)
