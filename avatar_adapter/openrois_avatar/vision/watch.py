"""Watching the operator's camera for all who want to know: one analysis, in a thread of its own, at a bounded rate."""

import asyncio
import logging
import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from typing import Final

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawVideo

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois_avatar.devices import Camera
from openrois_avatar.sensing.activity import Activity
from openrois_avatar.sensing.figures import SenseFigures
from openrois_avatar.vision.analysis import Analysis
from openrois_avatar.vision.seen import Seen
from openrois_avatar.vision.view import View

__all__ = ["BLIND", "PATIENCE", "RATE", "Watch"]

_log = logging.getLogger(__name__)

RATE: Final = 10.0
"""Pictures a second that are analysed at most; of others only the newest is kept."""
BLIND: Final = 2.0
"""Seconds without a picture after which nobody is seen any more."""
PATIENCE: Final = 10.0
"""Seconds that the analysis of one picture may take: a backend that takes longer does not return at all."""
_RECOVERY: Final = 1.0
"""Seconds after an analysis that failed until the next one."""
_NICENESS: Final = 5
"""How far the thread stands back behind encoders and decoders."""


class Watch:
    """The pictures of a camera, analysed while somebody wants it, and only then. `run` must run.

    Args:
        camera: whose pictures.
        clock: paces the analysis.
        analysis: what looks at them; it begins anew whenever the watch does.
        failure: why nothing can be seen here from the beginning, if that is so.
    """

    def __init__(self, camera: Camera, clock: MediaClock, analysis: Analysis, failure: str = "") -> None:
        self.seen: Listeners[Seen] = Listeners()
        """Are told what is seen in each picture; and nobody, again and again, while none come: some may begin then."""
        self.figures = SenseFigures()
        self.failure = failure
        """Why nothing can be seen now; empty while all is well."""
        self._camera = camera
        self._clock = clock
        self._analysis = analysis
        self._wishes: list[Activity] = []
        self._collectors = 0
        self._changed = asyncio.Event()
        self._hung = bool(failure)
        self._looking: asyncio.Future[Seen] | None = None
        """What the thread does now: never more than one thing waits for it."""
        self._due = 0.0
        self._anew = True
        self._looked_at = clock.now()

    def serve(self, activity: Activity) -> None:
        """Watch while `activity` works."""
        self._wishes.append(activity)
        activity.changed.add(lambda _works: self._changed.set())

    def wall_at(self, moment: float) -> float:
        """Return the time of day, in seconds since the epoch, of a moment of the media clock."""
        return wall_at(self._clock, moment)

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Watch, and give everybody's likeness with what is seen, for as long as the block runs."""
        self._collect(1)
        try:
            yield
        finally:
            self._collect(-1)

    async def run(self) -> None:
        """Watch for ever."""
        # One thread for all: what looks at the pictures is never in two of them.
        thread = ThreadPoolExecutor(1, "vision", _stand_back)
        try:
            while not self._hung:
                await self._until(wanted=True)
                async with TaskScope() as tasks:
                    tasks.start(self._look_on(thread))
                    tasks.start(self._notice_blindness())
                    await self._until(wanted=False)
                self._see_nobody()
                if not self._hung:
                    self.failure = ""
        finally:
            # It ends with the picture it is at; nobody waits for that.
            thread.shutdown(wait=False, cancel_futures=True)

    @property
    def _wanted(self) -> bool:
        return self._collectors > 0 or any(wish.works for wish in self._wishes)

    def _collect(self, more: int) -> None:
        self._collectors += more
        self._analysis.collects = self._collectors > 0
        self._changed.set()

    async def _until(self, *, wanted: bool) -> None:
        while self._wanted != wanted and not self._hung:
            self._changed.clear()
            await self._changed.wait()

    async def _look_on(self, thread: ThreadPoolExecutor) -> None:
        self._anew = True
        self._looked_at = self._clock.now()
        async with self._camera.inlet.subscribe(1) as pictures:
            while not self._hung:
                picture = await pictures.get()
                self._looked_at = self._clock.now()
                pause = await self._look(thread, picture)
                await self._clock.sleep_until(self._looked_at + pause)

    async def _look(self, thread: ThreadPoolExecutor, picture: RawVideo) -> float:
        """Look at a picture and return the seconds until the next one."""
        loop = asyncio.get_running_loop()
        if self._looking is not None and not await self._returned(self._looking):
            return 0.0
        anew, self._anew = self._anew, False
        looking = self._looking = loop.run_in_executor(thread, self._analyse, View(picture), anew)
        self._due = loop.time() + PATIENCE
        if not await self._returned(looking):
            return 0.0
        error = looking.exception()
        if error is None:
            self.failure = ""
            self.seen.tell(looking.result())
            return 1 / RATE
        if not self.failure:
            _log.error("camera: a picture cannot be analysed", exc_info=error)
        self.failure = f"a picture cannot be analysed: {error!r}"
        self._see_nobody()
        self._anew = True
        return _RECOVERY

    def _analyse(self, view: View, anew: bool) -> Seen:
        if anew:
            self._analysis.forget()
        return self._analysis.look(view)

    async def _returned(self, looking: asyncio.Future[Seen]) -> bool:
        """Wait until an analysis has returned, perhaps one that was begun before the watch was interrupted."""
        await asyncio.wait({looking}, timeout=self._due - asyncio.get_running_loop().time())
        if looking.done():
            self._looking = None
            self.figures.seconds += PATIENCE - (self._due - asyncio.get_running_loop().time())
            if looking.exception() is None:
                self.figures.analysed += 1
            else:
                self.figures.failed += 1
            return True
        self.figures.failed += 1
        self._hung, self.failure = True, f"the analysis does not return after {PATIENCE:.0f} s"
        _log.error("camera: %s; it is given up", self.failure)
        self._changed.set()
        return False

    async def _notice_blindness(self) -> None:
        while True:
            await self._clock.sleep_until(max(self._looked_at, self._clock.now()) + BLIND)
            if self._clock.now() - self._looked_at >= BLIND:
                self._see_nobody()
                if self._looking is None:
                    # What failed is not there any more.
                    self.failure = ""

    def _see_nobody(self) -> None:
        # Also if nobody was seen last: who was paused then may have told of somebody before.
        self.seen.tell(Seen(self._clock.now()))


def _stand_back() -> None:
    # Where a thread has a priority of its own, it is one with which pictures and sound come first.
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
