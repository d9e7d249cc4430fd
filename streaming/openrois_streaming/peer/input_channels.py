"""The two data channels of a peer connection, over which an application sends what a person does."""

from collections.abc import Callable, Sequence
from typing import Final, Protocol, TypeAlias

from aiortc import RTCDataChannel, RTCPeerConnection

from openrois_streaming.aiortc_internals.channels import contain_channels
from openrois_streaming.input.messages import MESSAGE_LIMIT
from openrois_streaming.input.reader import Label
from openrois_streaming.network.guard import GuardFigures

__all__ = [
    "CONTROL_ID",
    "INPUT_ID",
    "Channels",
    "InputPath",
    "InputSink",
    "MakeChannels",
    "OpenChannels",
    "SessionInput",
    "Take",
    "is_open",
    "send",
]

INPUT_ID: Final = 0
CONTROL_ID: Final = 1
"""The negotiated ids of the channels."""
UNSENT_LIMIT: Final = 16 * 1024
"""Bytes that may wait to be sent to the application; then it is told no more."""

_LABELS: Final[dict[int, Label]] = {INPUT_ID: "input", CONTROL_ID: "control"}


Take: TypeAlias = Callable[[Label, str | bytes], None]
"""Gets each message and the channel it came in."""


class InputSink(Protocol):
    """Who hears what an application sends over its channels. All calls are made in the event loop."""

    def input_came(self, label: Label, data: str | bytes) -> None:
        """A message, as it came."""
        ...

    def input_lost(self, reason: str) -> None:
        """Nothing can come any more over any peer connection of the application, until something comes again."""
        ...


class Channels:
    """`input`, unordered and never repeated, and `control`, which keeps the order and loses nothing.

    Both are negotiated, so they have to be made before the connection is described.

    Args:
        connection: a peer connection with at least one section.
        figures: where is counted what is not taken in.
        take: gets each message.
        on_closed: called when they are closed, by either end.
    """

    def __init__(
        self,
        connection: RTCPeerConnection,
        figures: GuardFigures,
        take: Take,
        on_closed: Callable[[], None],
    ) -> None:
        self._take = take
        self._input = connection.createDataChannel(
            "input", negotiated=True, id=INPUT_ID, ordered=False, maxRetransmits=0
        )
        self._control = connection.createDataChannel("control", negotiated=True, id=CONTROL_ID)
        for channel in (self._input, self._control):
            channel.on("close", on_closed)
        contain_channels(self._control.transport, MESSAGE_LIMIT, figures, self._came)

    @property
    def are_open(self) -> bool:
        """Whether messages can come in both."""
        return is_open(self._input) and is_open(self._control)

    def tell(self, message: str | bytes) -> bool:
        """Send the application a message over `control`; False if it is not open, or the application does not read."""
        return send(self._control, message)

    def _came(self, stream_id: int, data: str | bytes) -> None:
        label = _LABELS.get(stream_id)
        if label is not None:
            self._take(label, data)


class OpenChannels(Protocol):
    """Channels that were made, as far as others look at them."""

    @property
    def are_open(self) -> bool:
        """Whether messages can come in both."""
        ...

    def tell(self, message: str | bytes) -> bool:
        """Send the application a message; False if it cannot be told."""
        ...


MakeChannels: TypeAlias = Callable[[RTCPeerConnection, GuardFigures, Take, Callable[[], None]], OpenChannels]
"""Makes the channels of a peer connection, with the arguments of `Channels`."""


class InputPath:
    """The way of what a person does over one peer connection, which has no data channels until they are wanted.

    Args:
        make: makes them.
        renegotiate: offers them.
        on_closed: called once, when they are closed before the connection ends.
    """

    def __init__(
        self,
        make: Callable[[Take, Callable[[], None]], OpenChannels],
        renegotiate: Callable[[], None],
        on_closed: Callable[[], None],
    ) -> None:
        self._make = make
        self._renegotiate = renegotiate
        self._on_closed = on_closed
        self._channels: OpenChannels | None = None
        self._ended = False

    def want(self, take: Take) -> None:
        """Have them from the next offer on, and give `take` what comes; wanting them twice is fine."""
        if self._channels is None:
            self._channels = self._make(take, self._closed)
            self._renegotiate()

    @property
    def is_open(self) -> bool:
        """Whether messages can come."""
        return self._channels is not None and not self._ended and self._channels.are_open

    def tell(self, message: str | bytes) -> bool:
        """Tell the application something; False if it cannot be told over this way."""
        return self._channels is not None and not self._ended and self._channels.tell(message)

    def end(self) -> None:
        """The connection has ended."""
        self._ended = True

    def _closed(self) -> None:
        if not self._ended:
            self._ended = True
            self._on_closed()


class SessionInput:
    """What the person at an application does, over whichever peer connections it has.

    Args:
        sink: hears it; None: nobody wants to know, and there are no channels.
        ways: of the peer connections that have not ended, the present one first.
    """

    def __init__(self, sink: InputSink | None, ways: Callable[[], Sequence[InputPath]]) -> None:
        self._sink = sink
        self._ways = ways
        self._wanted = False

    def open(self) -> None:
        """Have channels on every peer connection from now on; doing it twice is fine."""
        self._wanted = True
        self.follow()

    def follow(self) -> None:
        """The present peer connection may be another one."""
        if self._wanted and self._sink is not None:
            for way in self._ways()[:1]:
                way.want(self._sink.input_came)

    def tell(self, message: str | bytes) -> None:
        """Tell the application something; lost where no channel is open for it, or the application is too slow."""
        any(way.tell(message) for way in self._ways())

    def lost(self, reason: str) -> None:
        """Nothing comes over one of the ways any more."""
        if self._wanted and self._sink is not None and not any(way.is_open for way in self._ways()):
            self._sink.input_lost(reason)


def is_open(channel: RTCDataChannel) -> bool:
    """Whether messages can be sent over a channel, and come."""
    return bool(channel.readyState == "open")


def send(channel: RTCDataChannel, message: str | bytes) -> bool:
    """Send a message; False if the channel is not open, or too much waits to be sent already."""
    sent = is_open(channel) and channel.bufferedAmount < UNSENT_LIMIT
    if sent:
        channel.send(message)
    return sent
