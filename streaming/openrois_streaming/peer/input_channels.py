"""Data channels of an application: `input`, `control` and `speech` of one peer connection."""

from collections.abc import Callable, Sequence
from typing import Final, Protocol, TypeAlias

from aiortc import RTCDataChannel, RTCPeerConnection

from openrois_streaming.aiortc_internals.channels import contain_channels
from openrois_streaming.input.reader import Label
from openrois_streaming.input.speech import SPEECH_MESSAGE_LIMIT
from openrois_streaming.network.guard import GuardFigures

__all__ = [
    "CONTROL_ID",
    "INPUT_ID",
    "SPEECH_ID",
    "SPEECH_UNSENT_LIMIT",
    "UNSENT_LIMIT",
    "Channels",
    "InputPath",
    "InputSink",
    "MakeChannels",
    "OnMessage",
    "OpenChannels",
    "SessionInput",
    "is_open",
    "send",
]

INPUT_ID: Final = 0
CONTROL_ID: Final = 1
SPEECH_ID: Final = 2
"""Negotiated ids of the channels."""
UNSENT_LIMIT: Final = 16 * 1024
"""Bytes that may wait to be sent to the application; beyond that messages are dropped."""
SPEECH_UNSENT_LIMIT: Final = 64 * 1024
"""Likewise over `speech`: its credit does not fill that before the connection is given up, and the application waits to
be told the end of each speech."""

_LABELS: Final[dict[int, Label]] = {INPUT_ID: "input", CONTROL_ID: "control", SPEECH_ID: "speech"}


OnMessage: TypeAlias = Callable[[Label, str | bytes], None]
"""Callback for each message with its channel."""


class InputSink(Protocol):
    """Sink of the messages of an application's channels. All calls are made in the event loop."""

    def input_came(self, label: Label, data: str | bytes) -> None:
        """Handle a message as it came."""
        ...

    def input_lost(self, reason: str) -> None:
        """Handle the loss of all channels of the application; input may come again later."""
        ...


class Channels:
    """Channels `input`, unordered and unreliable, `control` and `speech`, ordered and reliable.

    All are negotiated, so they must be made before the connection is described.

    Args:
        connection: a peer connection with at least one section.
        figures: count dropped data.
        on_message: gets each message.
        on_closed: called when either end closes them.
    """

    def __init__(
        self,
        connection: RTCPeerConnection,
        figures: GuardFigures,
        on_message: OnMessage,
        on_closed: Callable[[], None],
    ) -> None:
        self._on_message = on_message
        self._input = connection.createDataChannel(
            "input", negotiated=True, id=INPUT_ID, ordered=False, maxRetransmits=0
        )
        self._control = connection.createDataChannel("control", negotiated=True, id=CONTROL_ID)
        self._speech = connection.createDataChannel("speech", negotiated=True, id=SPEECH_ID)
        for channel in (self._input, self._control, self._speech):
            channel.on("close", on_closed)
        contain_channels(self._control.transport, SPEECH_MESSAGE_LIMIT, figures, self._receive)

    @property
    def are_open(self) -> bool:
        """Whether all channels are open."""
        return is_open(self._input) and is_open(self._control) and is_open(self._speech)

    def send_message(self, message: str | bytes, label: Label = "control") -> bool:
        """Send the application a message over `control` or `speech`; False if it is not open, or too much waits."""
        if label == "speech":
            return send(self._speech, message, SPEECH_UNSENT_LIMIT)
        return send(self._control, message)

    def _receive(self, stream_id: int, data: str | bytes) -> None:
        label = _LABELS.get(stream_id)
        if label is not None:
            self._on_message(label, data)


class OpenChannels(Protocol):
    """Data channels of one peer connection."""

    @property
    def are_open(self) -> bool:
        """Whether all channels are open."""
        ...

    def send_message(self, message: str | bytes, label: Label = "control") -> bool:
        """Send the application a message; False if it cannot be sent."""
        ...


MakeChannels: TypeAlias = Callable[[RTCPeerConnection, GuardFigures, OnMessage, Callable[[], None]], OpenChannels]
"""Factory of the channels of a peer connection, with the arguments of `Channels`."""


class InputPath:
    """Operator input over one peer connection, which has no data channels until they are wanted.

    Args:
        make: makes the channels.
        renegotiate: makes an offer with them.
        on_closed: called once, if they are closed before the connection ends.
    """

    def __init__(
        self,
        make: Callable[[OnMessage, Callable[[], None]], OpenChannels],
        renegotiate: Callable[[], None],
        on_closed: Callable[[], None],
    ) -> None:
        self._make = make
        self._renegotiate = renegotiate
        self._on_closed = on_closed
        self._channels: OpenChannels | None = None
        self._ended = False

    def want(self, on_message: OnMessage) -> None:
        """Make the channels for the next offer, with `on_message`; further calls have no effect."""
        if self._channels is None:
            self._channels = self._make(on_message, self._closed)
            self._renegotiate()

    @property
    def is_open(self) -> bool:
        """Whether the channels are open."""
        return self._channels is not None and not self._ended and self._channels.are_open

    def send_message(self, message: str | bytes, label: Label = "control") -> bool:
        """Send the application a message; False if it cannot be sent over this connection."""
        return self._channels is not None and not self._ended and self._channels.send_message(message, label)

    def close(self) -> None:
        """Close with the connection."""
        self._ended = True

    def _closed(self) -> None:
        if not self._ended:
            self._ended = True
            self._on_closed()


class SessionInput:
    """Operator input of an application, over all of its peer connections.

    Args:
        sink: gets the input; None: there are no channels.
        ways: returns the input paths of the peer connections that have not ended, the present one first.
    """

    def __init__(self, sink: InputSink | None, ways: Callable[[], Sequence[InputPath]]) -> None:
        self._sink = sink
        self._ways = ways
        self._wanted = False

    def open(self) -> None:
        """Open channels on every peer connection from now on; further calls have no effect."""
        self._wanted = True
        self.follow()

    def follow(self) -> None:
        """Open channels on the present peer connection, which may be a new one."""
        if self._wanted and self._sink is not None:
            for way in self._ways()[:1]:
                way.want(self._sink.input_came)

    def send_message(self, message: str | bytes, label: Label = "control") -> None:
        """Send the application a message; it is lost if no channel is open, or the application is too slow."""
        any(way.send_message(message, label) for way in self._ways())

    def lost(self, reason: str) -> None:
        """Notify the sink if the last open channels were lost."""
        if self._wanted and self._sink is not None and not any(way.is_open for way in self._ways()):
            self._sink.input_lost(reason)


def is_open(channel: RTCDataChannel) -> bool:
    """Tell whether a channel is open."""
    return bool(channel.readyState == "open")


def send(channel: RTCDataChannel, message: str | bytes, unsent_limit: int = UNSENT_LIMIT) -> bool:
    """Send a message; False if the channel is not open, or too much waits to be sent already."""
    sent = is_open(channel) and channel.bufferedAmount < unsent_limit
    if sent:
        channel.send(message)
    return sent
