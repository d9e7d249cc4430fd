"""Data channel announced to the application, for protocols other than `input`."""

from collections.abc import Callable
from dataclasses import dataclass

from aiortc import RTCPeerConnection

from openrois_streaming.aiortc_internals.channels import contain_channels
from openrois_streaming.input.reader import Label
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.peer.input_channels import OnMessage, OpenChannels, is_open, send

__all__ = ["AnnouncedChannel"]


@dataclass(frozen=True, slots=True)
class AnnouncedChannel:
    """Factory of an announced channel; a `MakeChannels`.

    The channel is ordered and reliable. It is announced as soon as there is a connection (RFC 8832).

    Attributes:
        label: its name.
        message_limit: limit on the bytes of a message, as the application is told.
        on_open: called each time that a channel opens.
    """

    label: str
    message_limit: int
    on_open: Callable[[], None]

    def __call__(
        self, connection: RTCPeerConnection, figures: GuardFigures, on_message: OnMessage, on_closed: Callable[[], None]
    ) -> OpenChannels:
        """Make the channel; its messages are passed to `on_message` as of `control`."""
        return _Announced(self, connection, figures, on_message, on_closed)


class _Announced:
    """Announced channel; an `OpenChannels`."""

    def __init__(
        self,
        made: AnnouncedChannel,
        connection: RTCPeerConnection,
        figures: GuardFigures,
        on_message: OnMessage,
        on_closed: Callable[[], None],
    ) -> None:
        self._on_message = on_message
        self._channel = connection.createDataChannel(made.label)
        self._channel.on("open", made.on_open)
        self._channel.on("close", on_closed)
        contain_channels(self._channel.transport, made.message_limit, figures, self._receive)

    @property
    def are_open(self) -> bool:
        """Whether the channel is open."""
        return is_open(self._channel)

    def send_message(self, message: str | bytes, _label: Label = "control") -> bool:
        """Send the application a message; False if it cannot be sent."""
        return send(self._channel, message)

    def _receive(self, stream_id: int, data: str | bytes) -> None:
        if stream_id == self._channel.id:
            self._on_message("control", data)
