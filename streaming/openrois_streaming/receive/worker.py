"""A thread that belongs to an opened source and ends with it."""

import asyncio
import contextlib
import logging
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

JOIN_TIMEOUT = 2.0
"""Seconds that closing waits for the thread to finish what it is at."""

_log = logging.getLogger(__name__)


class Worker:
    """Runs `work` in a thread for as long as the async context lasts. `work` returns soon after `stop` was called.

    `failed` is told, in the thread, what `work` raises: nothing comes any more.
    """

    def __init__(
        self, name: str, work: Callable[[], None], stop: Callable[[], None], failed: Callable[[Exception], None]
    ) -> None:
        self._stop = stop
        self._failed = failed
        self._work = work
        self._finished = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._thread.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()
        try:
            async with asyncio.timeout(JOIN_TIMEOUT):
                await self._finished.wait()
        except TimeoutError:
            _log.error("%s: the decoder does not return; its thread is abandoned", self._thread.name)
        else:
            # It has nothing left to do but to return.
            self._thread.join(JOIN_TIMEOUT)

    def _run(self) -> None:
        try:
            self._work()
        except Exception as error:
            _log.exception("%s: decoding has ended", self._thread.name)
            self._failed(error)
        finally:
            # A loop that was closed without closing this context has nobody left who wants to know.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._finished.set)
