"""One source, many readers: who shares it, who loses what, and who learns of its end."""

import asyncio
import logging
from collections import deque
from types import TracebackType
from typing import Generic, Protocol, Self, TypeVar

from openrois_streaming.source.source import MediaSource

T = TypeVar("T")

CLOSE_TIMEOUT = 5.0
"""Seconds that the last reader waits for its source to close before it goes its way."""

_log = logging.getLogger(__name__)


class SourceEnded(Exception):
    """The source has no more items. `__cause__` is the failure that ended it; None when it simply came to its end."""


class Mailbox(Protocol[T]):
    """The bounded queue of one reader. It never waits: what does not fit is lost, by a rule of its own."""

    def put(self, item: T) -> int:
        """Take `item` in and return how many items, queued ones or `item` itself, were lost by doing so."""
        ...

    def take(self) -> T:
        """Remove and return the oldest item; called only when there is one."""
        ...

    def awaited(self) -> None:
        """Note that the reader waits and there is nothing for it."""
        ...

    def __len__(self) -> int: ...


class DropOldest(Generic[T]):
    """A mailbox of `maxsize` >= 1 items that makes room by losing its oldest one."""

    __slots__ = ("_items",)

    def __init__(self, maxsize: int) -> None:
        if maxsize < 1:
            raise ValueError(f"a mailbox holds at least one item, not {maxsize}")
        self._items: deque[T] = deque(maxlen=maxsize)

    def put(self, item: T) -> int:
        """Append `item`; returns 1 if the oldest one had to go."""
        lost = int(len(self._items) == self._items.maxlen)
        self._items.append(item)
        return lost

    def take(self) -> T:
        """Remove and return the oldest item."""
        return self._items.popleft()

    def awaited(self) -> None:
        """Nothing to do: the next item is as good as any."""

    def __len__(self) -> int:
        return len(self._items)


class Subscription(Generic[T]):
    """One reader of a fan-out, inside `async with`: entering it opens the source if nobody else reads.

    `delivered` counts the items that were read, `dropped` those that were lost because this reader was too slow.
    """

    __slots__ = ("_cause", "_ended", "_fanout", "_left", "_mailbox", "_run", "_waiter", "delivered", "dropped")

    def __init__(self, fanout: "Fanout[T]", mailbox: Mailbox[T]) -> None:
        self._fanout = fanout
        self._mailbox = mailbox
        self._run: _Run[T] | None = None
        self._waiter: asyncio.Future[None] | None = None
        self._ended = self._left = False
        self._cause: Exception | None = None
        self.delivered = 0
        self.dropped = 0

    async def __aenter__(self) -> Self:
        if self._run is not None:
            raise RuntimeError("a subscription is entered only once")
        self._run = self._fanout._join(self)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        assert self._run is not None, "left before it was entered"
        self._left = True
        self._wake()
        if self.dropped:
            _log.info("%s: a reader took %d and lost %d", self._fanout.name, self.delivered, self.dropped)
        await self._fanout._leave(self, self._run)

    async def get(self) -> T:
        """Wait for the next item.

        Raises:
            SourceEnded: everything queued before the end has been read; `__cause__` is the failure, if there was one.
                Each later call raises it again. To go on, leave this subscription and enter a new one.
            RuntimeError: the subscription is not open, or somebody else is waiting on it.
        """
        while not self._mailbox:
            if self._ended:
                raise SourceEnded(f"{self._fanout.name} has ended") from self._cause
            if self._run is None or self._left or self._waiter is not None:
                raise RuntimeError("a subscription is read inside its context, by one reader")
            self._mailbox.awaited()
            self._waiter = asyncio.get_running_loop().create_future()
            try:
                await self._waiter
            finally:
                self._waiter = None
        self.delivered += 1
        return self._mailbox.take()

    def _put(self, item: T) -> None:
        self.dropped += self._mailbox.put(item)
        if self._mailbox:
            self._wake()

    def _end(self, cause: Exception | None) -> None:
        self._ended, self._cause = True, cause
        self._wake()

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)


class _Run(Generic[T]):
    """One opening of the source: its puller, and those who read what it brings."""

    __slots__ = ("ended", "readers", "task")

    def __init__(self) -> None:
        self.readers: list[Subscription[T]] = []
        self.ended = False
        self.task: asyncio.Task[None] | None = None

    def end(self, cause: Exception | None) -> None:
        """Tell every reader. Only the first end counts."""
        if not self.ended:
            self.ended = True
            for reader in self.readers:
                reader._end(cause)


class Fanout(Generic[T]):
    """Shares one source among any number of readers, each with a bounded queue of its own.

    The source is opened when the first reader comes and closed when the last one has left. One task pulls it; a reader
    that stalls loses items of its own and slows down nobody. When the source ends or fails, every reader learns of it
    after the items it still has queued; whoever subscribes afterwards opens the source anew.

    `pulled` counts the items that came from the source, over all its openings. `failure` is why it ended last, if that
    was a failure and no item has come since.
    """

    def __init__(self, source: MediaSource[T], *, name: str, close_timeout: float = CLOSE_TIMEOUT) -> None:
        self.name = name
        self.pulled = 0
        self.failure: Exception | None = None
        self._source = source
        self._close_timeout = close_timeout
        self._run: _Run[T] | None = None
        self._pullers: set[asyncio.Task[None]] = set()
        """The one that pulls, and those that still close what they pulled."""

    @property
    def readers(self) -> int:
        """How many subscriptions are open on the current opening of the source."""
        return 0 if self._run is None else len(self._run.readers)

    @property
    def running(self) -> bool:
        """Whether the source is open or opening, and has not ended."""
        return self._run is not None and not self._run.ended

    def subscribe(self, maxsize: int = 2, *, mailbox: Mailbox[T] | None = None) -> Subscription[T]:
        """A subscription to enter with `async with`. It gets what is pulled after that, `maxsize` items at most queued.

        Args:
            maxsize: the size of its queue, which loses the oldest item first.
            mailbox: a queue with another rule; `maxsize` is then ignored.
        """
        return Subscription(self, DropOldest(maxsize) if mailbox is None else mailbox)

    def _join(self, reader: Subscription[T]) -> _Run[T]:
        run = self._run
        if run is None or run.ended:
            run = self._run = _Run()
            run.task = asyncio.create_task(self._pull(run, set(self._pullers)), name=f"pull {self.name}")
            self._pullers.add(run.task)
            run.task.add_done_callback(self._pullers.discard)
        run.readers.append(reader)
        return run

    async def _leave(self, reader: Subscription[T], run: _Run[T]) -> None:
        run.readers.remove(reader)
        if run.readers:
            return
        if self._run is run:
            self._run = None
        assert run.task is not None, "a run has a task from its first reader on"
        run.task.cancel()
        _, late = await asyncio.wait({run.task}, timeout=self._close_timeout)
        if late:
            _log.error("%s: the source is not closed after %.1f s", self.name, self._close_timeout)

    async def _pull(self, run: _Run[T], earlier: set[asyncio.Task[None]]) -> None:
        try:
            if earlier:
                # A source is never open twice at once.
                await asyncio.wait(earlier)
            async with self._source.open() as items:
                try:
                    async for item in items:
                        self.pulled += 1
                        self.failure = None
                        for reader in run.readers:
                            reader._put(item)
                except Exception as error:
                    # Told before the source closes, which may take its time.
                    self.failure = error
                    run.end(error)
                    raise
                run.end(None)
        except Exception as error:
            _log.warning("%s: the source failed: %r", self.name, error)
            if not run.ended:
                # What fails while it closes is not why it ended.
                self.failure = error
                run.end(error)
        finally:
            run.end(None)
