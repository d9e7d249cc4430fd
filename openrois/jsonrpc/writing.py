"""Sending on one connection: at once where nothing waits before it, and else all that waits with one write."""

import asyncio
from contextlib import suppress
from typing import Final

from openrois.jsonrpc.outbox import Outbox
from openrois.transport.stream import BatchStream, MessageStream, StreamClosed

__all__ = ["Writer"]

BATCH_TEXT: Final = 64 * 1024
"""Characters that are handed over at once; what comes behind them may still be dropped."""

UNCOUNTED: Final = 4096
"""Characters of a message that is sent at once: what is longer counts as unread until the stream has taken it."""


class Writer:
    """The way from an outbox to a stream.

    While messages come one in a turn of the loop each leaves at once, and waits for no other task. Where more come, all
    of a turn leave together with the next, for what one write costs.
    """

    def __init__(self, stream: MessageStream, outbox: Outbox) -> None:
        self._stream = stream
        self._batches = stream if isinstance(stream, BatchStream) else None
        self._outbox = outbox
        self._is_busy = False
        self._is_sending = False

    def put(self, text: str, *, droppable: bool = False) -> None:
        """Send a message, or have it wait behind those that do.

        Args:
            text: the message.
            droppable: an event that may be dropped, oldest first, when too many wait.

        Raises:
            OutboxOverflow: a control message no longer fits.
        """
        # What is long may wait in the stream for as long as the other side likes: it counts meanwhile.
        is_long = len(text) > UNCOUNTED
        if is_long or self._is_busy or self._batches is None or len(self._outbox) or not self._batches.send_now(text):
            self._outbox.put(text, droppable=droppable)
        else:
            self._is_busy = True
            asyncio.get_running_loop().call_soon(self._turn)

    def _turn(self) -> None:
        # Where more have come, they are on their way by now.
        self._is_busy = self._is_sending or len(self._outbox) > 0

    async def run(self) -> None:
        """Send what waits until the stream has ended."""
        with suppress(StreamClosed):
            if self._batches is None:
                while True:
                    await self._stream.send(await self._outbox.get())
            while True:
                texts = await self._outbox.get_some(BATCH_TEXT)
                # While half of them wait for a slow reader nothing may pass.
                self._is_busy = self._is_sending = True
                await self._batches.send_many(texts)
                self._is_sending = False
                self._is_busy = len(texts) > 1
