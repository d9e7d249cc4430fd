"""Operator input and speech of a measuring viewer, sent over the data channels of one peer connection."""

import json
from collections.abc import Callable

from aiortc import RTCPeerConnection

from openrois_streaming.input.messages import Message, State
from openrois_streaming.peer.input_channels import CONTROL_ID, INPUT_ID, SPEECH_ID


class InputSender:
    """Application's ends of the data channels `input`, `control` and `speech`.

    Args:
        connection: a peer connection that was offered an application section.
        on_news: called when a message comes, or a channel opens or closes.
    """

    def __init__(self, connection: RTCPeerConnection, on_news: Callable[[], None]) -> None:
        self.received: list[str] = []
        """Messages of the session over `control`."""
        self.told: list[str] = []
        """Messages of the session over `speech`."""
        self._on_news = on_news
        self._input = connection.createDataChannel(
            "input", negotiated=True, id=INPUT_ID, ordered=False, maxRetransmits=0
        )
        self._control = connection.createDataChannel("control", negotiated=True, id=CONTROL_ID)
        self._speech = connection.createDataChannel("speech", negotiated=True, id=SPEECH_ID)
        self._control.on("message", self._receive)
        self._speech.on("message", self._hear)
        for channel in (self._input, self._control, self._speech):
            channel.on("open", on_news)
            channel.on("close", on_news)

    @property
    def are_open(self) -> bool:
        """Whether all channels are open."""
        return all(each.readyState == "open" for each in (self._input, self._control, self._speech))

    def send_message(self, message: Message) -> None:
        """Send an input message, states over `input` and changes over `control`.

        Raises:
            aiortc.InvalidStateError: the channels are not open.
        """
        (self._input if isinstance(message, State) else self._control).send(json.dumps(message.to_json()))

    def send(self, data: str | bytes, *, over_control: bool = False) -> None:
        """Send any data.

        Raises:
            aiortc.InvalidStateError: the channels are not open.
        """
        (self._control if over_control else self._input).send(data)

    def speak(self, data: str | bytes) -> None:
        """Send a frame or a message over `speech`.

        Raises:
            aiortc.InvalidStateError: the channels are not open.
        """
        self._speech.send(data)

    def _hear(self, text: str) -> None:
        self.told.append(text)
        self._on_news()

    def _receive(self, text: str) -> None:
        self.received.append(text)
        self._on_news()
