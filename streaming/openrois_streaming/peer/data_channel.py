"""One data channel that is announced to the application, for those that speak another protocol than `input`."""

from collections.abc import Callable
from dataclasses import dataclass

from aiortc import RTCPeerConnection

from openrois_streaming.aiortc_internals.channels import contain_channels
from openrois_streaming.network.guard import GuardFigures
from openrois_streaming.peer.input_channels import OpenChannels, Take, is_open, send

__all__ = ["AnnouncedChannel"]


@dataclass(frozen=True, slots=True)
class AnnouncedChannel:
    """How such a channel is made; a `MakeChannels`.

    It keeps the order and loses nothing. The application hears of it as soon as there is a connection (RFC 8832).

    Attributes:
        label: its name.
        message_limit: bytes of a message that the application is told it may send.
        on_open: called each time that one is open.
    """

    label: str
    message_limit: int
    on_open: Callable[[], None]

    def __call__(
        self, connection: RTCPeerConnection, figures: GuardFigures, take: Take, on_closed: Callable[[], None]
    ) -> OpenChannels:
        """Make it; what comes in it is given to `take` as of `control`."""
        return _Announced(self, connection, figures, take, on_closed)


class _Announced:
    """An `OpenChannels`."""

    def __init__(
        self,
        made: AnnouncedChannel,
        connection: RTCPeerConnection,
        figures: GuardFigures,
        take: Take,
        on_closed: Callable[[], None],
    ) -> None:
        self._take = take
        self._channel = connection.createDataChannel(made.label)
        self._channel.on("open", made.on_open)
        self._channel.on("close", on_closed)
        contain_channels(self._channel.transport, made.message_limit, figures, self._came)

    @property
    def are_open(self) -> bool:
        """Whether messages can come."""
        return is_open(self._channel)

    def tell(self, message: str | bytes) -> bool:
        """Send the application a message; False if it cannot be told."""
        return send(self._channel, message)

    def _came(self, stream_id: int, data: str | bytes) -> None:
        if stream_id == self._channel.id:
            self._take("control", data)
