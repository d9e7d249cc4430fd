"""Media of a stream whose peer connection may be replaced: one source over changing paths."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Generic, Self, TypeVar

from openrois_streaming.source.source import MediaSource
from openrois_streaming.tasks import OwnedTasks

T = TypeVar("T")


class SwitchedSource(Generic[T]):
    """`MediaSource` of the newest path that has given an item.

    A path that is added plays beside the one before until its first item has come; then that one is closed. Without a
    path the iterator waits for the next one; it ends with `end_input`, or with the failure of a path.

    Args:
        name: in the names of tasks.
        depth: items that wait for the reader at most; the oldest is lost first.
        on_switch: called when the items of a path replace those of earlier ones, or are the first.
    """

    def __init__(self, name: str, depth: int, on_switch: Callable[[MediaSource[T]], None] = lambda _path: None) -> None:
        self.name = name
        self._depth = depth
        self._on_switch = on_switch
        self._paths: list[MediaSource[T]] = []
        self._opening: _Opening[T] | None = None
        self._ended = False

    def add(self, path: MediaSource[T]) -> None:
        """Add `path` as the newest one; a known path stays as it is."""
        if path in self._paths:
            return
        self._paths.append(path)
        if self._opening is not None:
            self._opening.play(path)

    def remove(self, path: MediaSource[T]) -> None:
        """Remove `path`; an unknown one is ignored."""
        if path in self._paths:
            self._paths.remove(path)
            if self._opening is not None:
                self._opening.stop(path)

    def end_input(self) -> None:
        """End the source: no path will be added."""
        self._ended = True
        if self._opening is not None:
            self._opening.end_input(None)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[T]]:
        """Play the paths while the context lasts.

        Raises:
            RuntimeError: it is open already.
        """
        if self._opening is not None:
            raise RuntimeError("the source is open already: close it first")
        opening = self._opening = _Opening(self.name, self._depth, self._switch)
        try:
            for path in self._paths:
                opening.play(path)
            if self._ended:
                opening.end_input(None)
            yield opening
        finally:
            await opening.aclose()
            self._opening = None

    def _switch(self, path: MediaSource[T]) -> None:
        for older in self._paths[: self._paths.index(path)]:
            self.remove(older)
        self._on_switch(path)


class _Opening(Generic[T]):
    """One opening of the source: a task for each path, and the items that wait."""

    def __init__(self, name: str, depth: int, switch: Callable[[MediaSource[T]], None]) -> None:
        self._name = name
        self._switch = switch
        self._items: deque[T] = deque(maxlen=depth)
        self._news = asyncio.Event()
        self._ended = False
        self._cause: BaseException | None = None
        self._tasks = OwnedTasks(name, self.end_input)
        self._playing: dict[MediaSource[T], asyncio.Task[None]] = {}

    def play(self, path: MediaSource[T]) -> None:
        self._playing[path] = self._tasks.start(self._play(path), "path")

    def stop(self, path: MediaSource[T]) -> None:
        playing = self._playing.pop(path, None)
        if playing is not None:
            playing.cancel()

    def end_input(self, cause: BaseException | None) -> None:
        if not self._ended:
            self._ended, self._cause = True, cause
            self._news.set()

    async def aclose(self) -> None:
        await self._tasks.aclose()

    async def _play(self, path: MediaSource[T]) -> None:
        first = True
        async with path.open() as items:
            async for item in items:
                if path not in self._playing:
                    return
                if first:
                    first = False
                    self._switch(path)
                self._items.append(item)
                self._news.set()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        while not self._items:
            if self._ended:
                if self._cause is not None:
                    raise self._cause
                raise StopAsyncIteration
            self._news.clear()
            await self._news.wait()
        return self._items.popleft()
