"""The shared analysis of the operator's camera: in a thread of its own, at a bounded rate, while a sense is active."""

import asyncio
import logging
import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import Final, TypeAlias

from openrois_media.devices import Camera
from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import RawVideo

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois_body.sensing.activity import Activity
from openrois_body.sensing.changes import Place
from openrois_body.sensing.figures import SenseFigures
from openrois_body.vision.analysis import Analysis
from openrois_body.vision.sighting import Person, Sighting
from openrois_body.vision.view import View

__all__ = ["BLIND", "PATIENCE", "RATE", "Locate", "Watch"]

_log = logging.getLogger(__name__)

Locate: TypeAlias = Callable[[Place, float], Place | None]
"""Function that returns where on the floor something is, by its place in the axes of the camera and the moment of the
picture; None where it is not known where the camera was."""

RATE: Final = 10.0
"""Most pictures a second that are analysed; of the others only the newest is kept."""
BLIND: Final = 2.0
"""Seconds without a picture after which no person is seen any more."""
PATIENCE: Final = 10.0
"""Seconds that the analysis of one picture may take, after which the backend counts as hung."""
_RECOVERY: Final = 1.0
"""Seconds after an analysis that failed until the next one."""
_NICENESS: Final = 5
"""Niceness of the thread, so that encoders and decoders come first."""


class Watch:
    """Analyses the pictures of a camera while a sense is active, and only then. `run` has to run.

    Args:
        camera: source of the pictures.
        clock: paces the analysis.
        analysis: analyses them; it begins anew whenever the watch does.
        failure: why pictures cannot be analysed from the beginning; empty if they can.
        locate: tells where on the floor persons are; None: their places are in the axes of the camera.
        camera_problem: returns why the camera has no pictures; empty where it has, or where they may come any time.
    """

    def __init__(
        self,
        camera: Camera,
        clock: MediaClock,
        analysis: Analysis,
        failure: str = "",
        *,
        locate: Locate | None = None,
        camera_problem: Callable[[], str] = lambda: "",
    ) -> None:
        self.seen: Listeners[Sighting] = Listeners()
        """Called with the persons of each picture; without pictures repeatedly with none, for senses that begin."""
        self.figures = SenseFigures()
        self.failure = failure
        """Why pictures cannot be analysed now; empty if they can."""
        self._camera = camera
        self._camera_problem = camera_problem
        self._clock = clock
        self._analysis = analysis
        self._locate = locate
        self._places: dict[int, Place] = {}
        """Where on the floor each person's face was seen last."""
        self._wishes: list[Activity] = []
        self._collectors = 0
        self._changed = asyncio.Event()
        self._hung = bool(failure)
        self._looking: asyncio.Future[Sighting] | None = None
        """The running analysis: never more than one."""
        self._due = 0.0
        self._anew = True
        self._looked_at = clock.now()

    def problem(self) -> str:
        """Return why persons cannot be seen now; empty where they can."""
        return self._camera_problem() or self.failure

    def serve(self, activity: Activity) -> None:
        """Watch while `activity` is active."""
        self._wishes.append(activity)
        activity.changed.add(lambda _works: self._changed.set())

    def wall_at(self, moment: float) -> float:
        """Return the time of day, in seconds since the epoch, of a moment of the media clock."""
        return wall_at(self._clock, moment)

    @contextmanager
    def collecting(self) -> Iterator[None]:
        """Watch, and add the likeness of each person, for as long as the block runs."""
        self._collect(1)
        try:
            yield
        finally:
            self._collect(-1)

    async def run(self) -> None:
        """Watch until cancelled."""
        # One thread for all: the analysis never runs in two.
        thread = ThreadPoolExecutor(1, "vision", _stand_back)
        try:
            while not self._hung:
                await self._until(wanted=True)
                async with TaskScope() as tasks:
                    tasks.start(self._analyse_pictures(thread))
                    tasks.start(self._notice_gap())
                    await self._until(wanted=False)
                self._clear_persons()
                if not self._hung:
                    self.failure = ""
        finally:
            # The thread ends after its present picture; that is not awaited.
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

    async def _analyse_pictures(self, thread: ThreadPoolExecutor) -> None:
        self._anew = True
        self._looked_at = self._clock.now()
        async with self._camera.inlet.subscribe(1) as pictures:
            while not self._hung:
                picture = await pictures.get()
                if not self._camera.may_recognise(picture):
                    continue
                self._looked_at = self._clock.now()
                pause = await self._analyse_picture(thread, picture)
                await self._clock.sleep_until(self._looked_at + pause)

    async def _analyse_picture(self, thread: ThreadPoolExecutor, picture: RawVideo) -> float:
        """Analyse a picture, and return the seconds until the next one."""
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
            # The consent may have been withdrawn meanwhile.
            if self._camera.may_recognise(picture):
                self.seen.notify_all(self._located(looking.result()))
            return 1 / RATE
        if not self.failure:
            _log.error("camera: a picture cannot be analysed", exc_info=error)
        self.failure = f"a picture cannot be analysed: {error!r}"
        self._clear_persons()
        self._anew = True
        return _RECOVERY

    def _located(self, seen: Sighting) -> Sighting:
        """Return what is seen with the places on the floor; persons without a known one are left out."""
        locate = self._locate
        if locate is None:
            return seen
        persons: list[Person] = []
        places: dict[int, Place] = {}
        for person in seen.persons:
            # Where the camera turns, a face that is not found any more is not where it was in the picture.
            now = locate(person.place, seen.moment) if person.face else None
            if (place := now or self._places.get(person.number)) is not None:
                places[person.number] = place
                persons.append(replace(person, place=place))
        self._places = places
        return replace(seen, persons=tuple(persons))

    def _analyse(self, view: View, anew: bool) -> Sighting:
        if anew:
            self._analysis.reset()
        return self._analysis.analyse_view(view)

    async def _returned(self, looking: asyncio.Future[Sighting]) -> bool:
        """Wait for an analysis, perhaps one from before an interruption; return whether it has ended in time."""
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
        self._hung = True
        self.failure = f"the analysis of a picture has not returned within {PATIENCE:.0f} s; restart the adapter"
        _log.error("camera: %s", self.failure)
        self._changed.set()
        return False

    async def _notice_gap(self) -> None:
        while True:
            await self._clock.sleep_until(max(self._looked_at, self._clock.now()) + BLIND)
            if self._clock.now() - self._looked_at >= BLIND:
                self._clear_persons()
                if self._looking is None:
                    # The picture that failed is gone.
                    self.failure = ""

    def _clear_persons(self) -> None:
        # Also if no person was seen last: a sense that was paused then may have announced one before.
        self.seen.notify_all(Sighting(self._clock.now()))


def _stand_back() -> None:
    # Where threads have priorities of their own, pictures and sound come first.
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
