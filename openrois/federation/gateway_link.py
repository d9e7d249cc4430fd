"""The way from one gateway to the others, as a federation needs it. Pure."""

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Protocol, Self

from openrois.cluster.presence import Present
from openrois.transport.stream import MessageStream, StreamClosed

__all__ = ["GatewayLink", "GatewayStream"]


class GatewayStream(MessageStream, Protocol):
    """A stream from another gateway.

    Attributes:
        closed: the reason for which it has ended, as soon as that is known; None while it lives.
    """

    closed: StreamClosed | None


class GatewayLink(Protocol):
    """The link of a gateway to the others of its cluster.

    Attributes:
        gateway_id: of this gateway.
        trouble: why no other gateway can be reached; empty where they can.
        gaps: number of streams that ended because a message was missing.
    """

    gateway_id: str
    trouble: str
    gaps: int

    @property
    def present(self) -> Mapping[str, Present]:
        """The gateways that are there, this one too, by id."""
        ...

    def notice_pause(self) -> None:
        """Lose all streams where this process stood still for so long that the others have given it up."""
        ...

    def count_streams(self) -> Mapping[str, int]:
        """Return how many streams there are with each gateway that has some."""
        ...

    def on_presence(self, listener: Callable[[Mapping[str, Present]], None]) -> Callable[[], None]:
        """Call `listener` when a gateway comes, changes or goes; return a function that removes it."""
        ...

    async def __aenter__(self) -> Self:
        """Begin to reach the others, and to be reached by them."""
        ...

    async def __aexit__(self, *_error: object) -> None: ...

    async def listen(self, handler: Callable[[GatewayStream, Mapping[str, Any]], Awaitable[None]]) -> None:
        """Let other gateways dial this one: the handler gets each stream and what is asserted, in a task of its own."""
        ...

    async def dial(self, gateway_id: str, hello: Mapping[str, Any]) -> MessageStream:
        """Return a stream to another gateway.

        Raises:
            DialFailed: it is not reached or refuses.
        """
        ...
