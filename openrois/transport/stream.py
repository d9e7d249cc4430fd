"""The contract of a message stream: what a session needs of a connection."""

from collections.abc import Sequence
from typing import Final, Protocol, runtime_checkable

__all__ = ["POLICY_VIOLATION", "BatchStream", "MessageStream", "StreamClosed", "close_reason"]

POLICY_VIOLATION: Final = 1008
"""The close code (RFC 6455, 7.4.1) for a peer that is not acceptable."""

_MAX_REASON = 123


class StreamClosed(Exception):
    """The stream has ended, by either side; nothing more is received or sent.

    Attributes:
        code: a WebSocket close code (RFC 6455, 7.4); 1006 where the connection broke without a closing handshake.
        reason: the other side's words, or empty.
    """

    def __init__(self, code: int = 1000, reason: str = "") -> None:
        super().__init__(f"closed with {code} {reason}".rstrip())
        self.code = code
        self.reason = reason


class MessageStream(Protocol):
    """An ordered, reliable, bounded stream of text messages in both directions.

    `receive` and `send` may run at the same time, each from one task only.
    """

    async def receive(self) -> str:
        """Wait for the next message.

        Raises:
            StreamClosed: no message will come any more.
        """
        ...

    async def send(self, text: str) -> None:
        """Hand over one message; waits while the other side is slow.

        Raises:
            StreamClosed: the message was not sent and never will be.
        """
        ...

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """End the stream politely, within a bounded time. Idempotent."""
        ...

    def abort(self) -> None:
        """End the stream at once, without a word: the other side may not be reading. Idempotent."""
        ...


@runtime_checkable
class BatchStream(Protocol):
    """A message stream that also sends several messages for little more than one, and one without waiting."""

    def send_now(self, text: str) -> bool:
        """Hand over one message if all before it have left, and tell whether that was so."""
        ...

    async def send_many(self, texts: Sequence[str]) -> None:
        """Hand over messages in this order; waits while the other side is slow.

        Raises:
            StreamClosed: some of them were not sent and never will be.
        """
        ...


def close_reason(text: str) -> str:
    """Return `text` cut to what fits into a close frame: 123 bytes of UTF-8 (RFC 6455, 5.5), whole characters."""
    return text.encode(errors="replace")[:_MAX_REASON].decode(errors="ignore")
