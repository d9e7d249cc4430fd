"""Inlet with many readers, which stays while senders come and go."""

import asyncio
import logging
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager
from typing import Generic, TypeVar

from openrois_streaming.source.ending import wait_until_ended
from openrois_streaming.source.fanout import Fanout, Mailbox, Subscription
from openrois_streaming.source.source import MediaSource

T = TypeVar("T")

_log = logging.getLogger(__name__)


class SharedInlet(Generic[T]):
    """`UplinkSink` for one sender at a time. Its media is decoded while there is a reader, and only then.

    Readers wait while there is no sender. A sender whose media fails is given up until another source is plugged in.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.stream_id: str | None = None
        """The stream that is plugged in."""
        self._source: MediaSource[T] | None = None
        self._changed = asyncio.Event()
        """Set, and replaced by another event, when another source is plugged in."""
        self._plugged = asyncio.Event()
        self._fanout = Fanout(self, name=name)

    def plug(self, stream_id: str, source: MediaSource[T]) -> None:
        """Read `source` from now on."""
        self._exchange(stream_id, source)

    def unplug(self, stream_id: str) -> None:
        """Stop reading the source of `stream_id`, unless another has replaced it."""
        if stream_id == self.stream_id:
            self._exchange(None, None)

    async def plugged(self) -> None:
        """Wait until a source is plugged in."""
        await self._plugged.wait()

    def subscribe(self, maxsize: int = 2, *, mailbox: Mailbox[T] | None = None) -> Subscription[T]:
        """Return a subscription to enter with `async with`; as `Fanout.subscribe`."""
        return self._fanout.subscribe(maxsize, mailbox=mailbox)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[T]]:
        """Open the media of the present sender, as a `MediaSource` that does not end; for one reader."""
        async with aclosing(self._items()) as items:
            yield items

    def _exchange(self, stream_id: str | None, source: MediaSource[T] | None) -> None:
        self.stream_id, self._source = stream_id, source
        if source is None:
            self._plugged.clear()
        else:
            self._plugged.set()
        self._changed.set()
        self._changed = asyncio.Event()

    async def _items(self) -> AsyncGenerator[T, None]:
        while True:
            source, changed = self._source, self._changed
            if source is not None:
                try:
                    async with source.open() as items, aclosing(_until(changed, items)) as own:
                        async for item in own:
                            yield item
                except Exception as error:
                    _log.warning("%s: the media of the sender cannot be read: %r", self.name, error)
            await changed.wait()


async def _until(over: asyncio.Event, items: AsyncIterator[T]) -> AsyncGenerator[T, None]:
    """Yield `items` until `over` is set."""
    ending = asyncio.ensure_future(over.wait())
    try:
        while not over.is_set():
            following = asyncio.ensure_future(anext(items))
            try:
                await asyncio.wait({following, ending}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                if not following.done():
                    following.cancel()
                    # Also where the reader leaves meanwhile: items that are being read cannot be closed.
                    await wait_until_ended(following)
            if following.cancelled():
                return
            try:
                item = following.result()
            except StopAsyncIteration:
                return
            yield item
    finally:
        ending.cancel()
