"""One source for many readers: sharing, losses of slow readers, and the end of the source."""

import asyncio
import logging
from collections import deque
from types import TracebackType
from typing import Generic, Protocol, Self, TypeVar

from openrois_streaming.source.ending import wait_until_ended
from openrois_streaming.source.source import MediaSource

T = TypeVar("T")

CLOSE_TIMEOUT = 5.0
"""Seconds that the last reader waits for its source to close."""

_log = logging.getLogger(__name__)


class SourceEnded(Exception):
    """End of a source. `__cause__` is the failure that ended it; None at its regular end."""


class Mailbox(Protocol[T]):
    """Bounded queue of one reader. It never waits: items that do not fit are lost, by a rule of its own."""

    def put(self, item: T) -> int:
        """Queue `item`; returns how many items, queued ones or `item` itself, were lost by that."""
        ...

    def pop(self) -> T:
        """Remove and return the oldest item; called only when there is one."""
        ...

    def awaited(self) -> None:
        """Note that the reader waits and the mailbox is empty."""
        ...

    def __len__(self) -> int: ...


class DropOldest(Generic[T]):
    """Mailbox of `maxsize` >= 1 items that makes room by losing its oldest one."""

    __slots__ = ("_items",)

    def __init__(self, maxsize: int) -> None:
        if maxsize < 1:
            raise ValueError(f"maxsize must be 1 or more, not {maxsize}")
        self._items: deque[T] = deque(maxlen=maxsize)

    def put(self, item: T) -> int:
        """Append `item`; returns 1 if the oldest one had to go."""
        lost = int(len(self._items) == self._items.maxlen)
        self._items.append(item)
        return lost

    def pop(self) -> T:
        """Remove and return the oldest item."""
        return self._items.popleft()

    def awaited(self) -> None:
        """Nothing to do: the next item is as good as any."""

    def __len__(self) -> int:
        return len(self._items)


class Subscription(Generic[T]):
    """One reader of a fan-out, inside `async with`: the first reader opens the source.

    `delivered` counts the items read, `dropped` those lost because this reader was too slow.
    """

    __slots__ = ("_cause", "_ended", "_fanout", "_left", "_mailbox", "_run", "_waiter", "delivered", "dropped")

    def __init__(self, fanout: "Fanout[T]", mailbox: Mailbox[T]) -> None:
        self._fanout = fanout
        self._mailbox = mailbox
        self._run: SourceRun[T] | None = None
        self._waiter: asyncio.Future[None] | None = None
        self._ended = self._left = False
        self._cause: Exception | None = None
        self.delivered = 0
        self.dropped = 0

    async def __aenter__(self) -> Self:
        if self._run is not None:
            raise RuntimeError("a subscription is entered only once: subscribe again")
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
            RuntimeError: the subscription is not open, or another task is waiting on it.
        """
        while not self._mailbox:
            if self._ended:
                raise SourceEnded(f"{self._fanout.name} has ended") from self._cause
            if self._run is None or self._left or self._waiter is not None:
                raise RuntimeError("a subscription is read inside its `async with`, by one task at a time")
            self._mailbox.awaited()
            self._waiter = asyncio.get_running_loop().create_future()
            try:
                await self._waiter
            finally:
                self._waiter = None
        self.delivered += 1
        return self._mailbox.pop()

    def _put(self, item: T) -> None:
        self.dropped += self._mailbox.put(item)
        if self._mailbox:
            self._wake()

    def _end_input(self, cause: Exception | None) -> None:
        self._ended, self._cause = True, cause
        self._wake()

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)


class SourceRun(Generic[T]):
    """One opening of the source: its pulling task and its readers."""

    __slots__ = ("ended", "readers", "task")

    def __init__(self) -> None:
        self.readers: list[Subscription[T]] = []
        self.ended = False
        self.task: asyncio.Task[None] | None = None

    def end_readers(self, cause: Exception | None) -> None:
        """End the input of every reader. Only the first end counts."""
        if not self.ended:
            self.ended = True
            for reader in self.readers:
                reader._end_input(cause)


class _FailureLog:
    """Log of a source that is tried again and again: its first failure, each other reason, and its recovery."""

    __slots__ = ("_name", "_reason", "failed")

    def __init__(self, name: str) -> None:
        self.failed = False
        self._name = name
        self._reason = ""

    def note_failure(self, error: Exception) -> None:
        """Log `error`, unless its reason is that of the try before."""
        reason = repr(error)
        if not self.failed or reason != self._reason:
            _log.warning("%s: the source failed: %s", self._name, reason)
        self.failed, self._reason = True, reason

    def note_recovery(self) -> None:
        """Log that items come again."""
        self.failed = False
        _log.info("%s: the source works again", self._name)


class Fanout(Generic[T]):
    """Source shared by any number of readers, each with a bounded queue of its own.

    The source is opened for the first reader and closed when the last one has left. One task pulls it; a reader that
    stalls loses items of its own and slows down no other. When the source ends or fails, every reader is notified after
    the items it still has queued; a later subscription opens the source anew.

    A subclass without a source has a `_feed` of its own.

    `pulled` counts the items of the source, over all its openings. `failure` is the failure that ended it last, if no
    item has come since.
    """

    def __init__(
        self, source: MediaSource[T] | None = None, *, name: str, close_timeout: float = CLOSE_TIMEOUT
    ) -> None:
        self.name = name
        self.pulled = 0
        self.failure: Exception | None = None
        self._source = source
        self._close_timeout = close_timeout
        self._failures = _FailureLog(name)
        self._run: SourceRun[T] | None = None
        self._pullers: set[asyncio.Task[None]] = set()
        """The pulling task, and earlier ones that still close the source."""

    @property
    def readers(self) -> int:
        """Number of subscriptions on the current opening of the source."""
        return 0 if self._run is None else len(self._run.readers)

    @property
    def running(self) -> bool:
        """Whether the source is open or opening, and has not ended."""
        return self._run is not None and not self._run.ended

    def subscribe(self, maxsize: int = 2, *, mailbox: Mailbox[T] | None = None) -> Subscription[T]:
        """Return a subscription to enter with `async with`. It gets later items, `maxsize` at most queued.

        Args:
            maxsize: the size of its queue, which loses the oldest item first.
            mailbox: a queue with another rule; `maxsize` is then ignored.
        """
        return Subscription(self, DropOldest(maxsize) if mailbox is None else mailbox)

    def drop_waiting(self) -> None:
        """Drop what waits for the readers."""
        for reader in () if self._run is None else self._run.readers:
            while reader._mailbox:
                reader._mailbox.pop()

    def _join(self, reader: Subscription[T]) -> SourceRun[T]:
        run = self._run
        if run is None or run.ended:
            run = self._run = SourceRun()
            run.task = asyncio.create_task(self._pull(run, set(self._pullers)), name=f"pull {self.name}")
            self._pullers.add(run.task)
            run.task.add_done_callback(self._pullers.discard)
        run.readers.append(reader)
        return run

    async def _leave(self, reader: Subscription[T], run: SourceRun[T]) -> None:
        run.readers.remove(reader)
        if run.readers:
            return
        if self._run is run:
            self._run = None
        assert run.task is not None, "a run has a task from its first reader on"
        run.task.cancel()
        try:
            await wait_until_ended(run.task, self._close_timeout)
        finally:
            if not run.task.done():
                _log.error("%s: the source is not closed after %.1f s", self.name, self._close_timeout)

    async def _pull(self, run: SourceRun[T], earlier: set[asyncio.Task[None]]) -> None:
        try:
            if earlier:
                # A source is never open twice at once.
                await asyncio.wait(earlier)
            await self._feed(run)
        except Exception as error:
            self._failures.note_failure(error)
            if not run.ended:
                # A failure while it closes is not why it ended.
                self.failure = error
                run.end_readers(error)
        finally:
            run.end_readers(None)

    async def _feed(self, run: SourceRun[T]) -> None:
        """Open the source, and put its items, until it ends or this is cancelled."""
        assert self._source is not None, "a fan-out without a source has a `_feed` of its own"
        async with self._source.open() as items:
            try:
                async for item in items:
                    self._put(run, item)
            except Exception as error:
                # Before the source closes, which may take its time.
                self.failure = error
                run.end_readers(error)
                raise
            run.end_readers(None)

    def _put(self, run: SourceRun[T], item: T) -> None:
        """Queue an item of the source for every reader."""
        self.pulled += 1
        self.failure = None
        if self._failures.failed:
            self._failures.note_recovery()
        for reader in run.readers:
            reader._put(item)
