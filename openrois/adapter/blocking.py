"""Warns an author about code that blocks the adapter: while one component blocks, everything in the process waits."""

import asyncio
import logging
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

__all__ = ["told_of_blocking"]

_log = logging.getLogger(__name__)

PATIENCE: Final = 1.0
"""Seconds that one callback may keep the loop busy."""

_PACKAGE: Final = str(Path(__file__).parents[1])


@contextmanager
def told_of_blocking(patience: float = PATIENCE) -> Iterator[None]:
    """Log where the loop of this thread is stuck when it is for longer than `patience`, once each time.

    It takes a second thread to see that: the first one has no time.
    """
    loop, blocked = asyncio.get_running_loop(), threading.get_ident()
    alive, over = threading.Event(), threading.Event()

    def watch() -> None:
        told = False
        while not over.wait(patience):
            if alive.is_set():
                told = False
                alive.clear()
                loop.call_soon_threadsafe(alive.set)
            elif not told:
                told = True
                _log.warning("%s", _where(blocked))

    alive.set()
    watching = threading.Thread(target=watch, name="told_of_blocking", daemon=True)
    watching.start()
    try:
        yield
    finally:
        over.set()
        watching.join()


def _where(thread: int) -> str:
    frames = traceback.extract_stack(sys._current_frames().get(thread))
    ours = [index for index, frame in enumerate(frames) if frame.filename.startswith(_PACKAGE)]
    theirs = frames[ours[-1] + 1 :] if ours else []
    place = "".join(traceback.format_list(theirs or frames[-1:])).rstrip()
    return (
        "this call blocks the adapter, and its gateway may drop the connection: "
        f"write `await asyncio.to_thread(...)`\n{place}"
    )
