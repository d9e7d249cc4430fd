"""Media of a stream whose peer connection may be replaced: one stream over changing paths, for many readers."""

import asyncio
from collections.abc import Callable
from typing import TypeVar

from openrois_streaming.source.fanout import Fanout, SourceRun
from openrois_streaming.source.source import MediaSource
from openrois_streaming.tasks import OwnedTasks

T = TypeVar("T")


class SwitchedSource(Fanout[T]):
    """Fan-out of the newest path that has given an item.

    A path that is added plays beside the one before until its first item has come; then that one is closed. Without a
    path the readers wait for the next one. Paths are open while there are readers. The input ends with `end_input`, or
    with the failure of a path.

    Args:
        name: in logs and in the names of tasks.
        on_switch: called when the items of a path replace those of earlier ones, or are the first.
    """

    def __init__(self, name: str, on_switch: Callable[[MediaSource[T]], None] = lambda _path: None) -> None:
        super().__init__(name=name)
        self._on_switch = on_switch
        self._paths: list[MediaSource[T]] = []
        self._playing: dict[MediaSource[T], asyncio.Task[None]] = {}
        self._present: tuple[SourceRun[T], OwnedTasks] | None = None
        self._ended = False
        self._cause: BaseException | None = None
        self._over = asyncio.Event()
        """Set when the present opening has no more items."""

    def add(self, path: MediaSource[T]) -> None:
        """Add `path` as the newest one; a known path stays as it is."""
        if path not in self._paths:
            self._paths.append(path)
            self._play(path)

    def remove(self, path: MediaSource[T]) -> None:
        """Remove `path`; an unknown one is ignored."""
        if path in self._paths:
            self._paths.remove(path)
            playing = self._playing.pop(path, None)
            if playing is not None:
                playing.cancel()

    def end_input(self) -> None:
        """End the stream: no path will be added."""
        self._ended = True
        self._over.set()

    async def _feed(self, run: SourceRun[T]) -> None:
        tasks = OwnedTasks(self.name, self._failed)
        self._present, self._cause = (run, tasks), None
        if not self._ended:
            self._over.clear()
        try:
            for path in self._paths:
                self._play(path)
            await self._over.wait()
            if self._cause is not None:
                raise self._cause
        finally:
            self._present = None
            self._playing.clear()
            await tasks.aclose()

    def _play(self, path: MediaSource[T]) -> None:
        if self._present is not None:
            run, tasks = self._present
            self._playing[path] = tasks.start(self._pass(path, run), "path")

    async def _pass(self, path: MediaSource[T], run: SourceRun[T]) -> None:
        first = True
        async with path.open() as items:
            async for item in items:
                if path not in self._playing:
                    return
                if first:
                    first = False
                    self._switch(path)
                self._put(run, item)

    def _switch(self, path: MediaSource[T]) -> None:
        for older in self._paths[: self._paths.index(path)]:
            self.remove(older)
        self._on_switch(path)

    def _failed(self, error: BaseException) -> None:
        self._cause = error
        self._over.set()
