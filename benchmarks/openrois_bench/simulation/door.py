"""What peers dial: a simulated gateway, or a real one."""

from typing import Protocol, Self

from openrois.transport.stream import BatchStream, MessageStream

__all__ = ["Door", "PeerStream"]


class PeerStream(MessageStream, BatchStream, Protocol):
    """A peer's end of a connection: what is said at once is sent with one write."""


class Door(Protocol):
    """A gateway, as its adapters and applications see it."""

    async def dial_adapter(self, engine_id: str) -> PeerStream:
        """Return an adapter's end of a new connection."""
        ...

    async def dial_application(self, owner: Self, subject: str, scope: str) -> PeerStream:
        """Return an application's end of a new connection.

        Args:
            owner: the gateway that owns the body of the application.
            subject: the name in its token.
            scope: the components in its token.
        """
        ...
