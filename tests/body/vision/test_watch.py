"""When the camera is watched, and what happens when it cannot be."""

import asyncio
import math
import threading
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime
from typing import Any

import numpy as np
import pytest
from openrois_body.components.persons import PersonDetection
from openrois_body.sensing.activity import Activity
from openrois_body.sensing.changes import Place
from openrois_body.vision.analysis import Analysis
from openrois_body.vision.box import Box, Face, place_on_floor
from openrois_body.vision.gallery import Gallery
from openrois_body.vision.head_reader import HeadReader
from openrois_body.vision.patterns import PatternRecognizer
from openrois_body.vision.sighting import Sighting
from openrois_body.vision.view import View
from openrois_body.vision.watch import BLIND, RATE, Watch
from openrois_media.devices import Camera
from openrois_streaming.source.source import RawVideo

from tests.support.streaming import FedSource, VirtualClock, settle


class ScriptedFinder:
    """A backend that always finds one face, or does what the test sets."""

    def __init__(self) -> None:
        self.does: Callable[[], object] = lambda: None
        self.face: Face | None = Face(Box(0.3, 0.3, 0.4, 0.4))

    def available(self) -> tuple[bool, str]:
        return True, ""

    def find(self, view: View, known: Sequence[Face]) -> Sequence[Face]:
        self.does()
        return [] if self.face is None else [self.face]


class Stage:
    """A watch whose camera is fed by hand."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.camera = Camera()
        self.source: FedSource[RawVideo] = FedSource()
        self.finder, self.gallery = ScriptedFinder(), Gallery()
        self.analysis = Analysis(self.finder, PatternRecognizer(), HeadReader(), self.gallery)
        self.at: Place | None = Place(0.0, 0.0, 0.0)
        self.watch = Watch(self.camera, self.clock, self.analysis, locate=self._locate)
        self.activity = Activity()
        self.watch.serve(self.activity)
        self.seen: asyncio.Queue[Sighting] = asyncio.Queue()
        self.watch.seen.add(self.seen.put_nowait)
        self.running = asyncio.ensure_future(self.watch.run())
        self._pixels = np.random.default_rng(5).integers(0, 255, (120, 160, 3)).astype(np.uint8)

    def _locate(self, seen: Place, _moment: float) -> Place | None:
        return None if self.at is None else place_on_floor(seen, self.at)

    async def show(self) -> None:
        """Let the camera send a picture, and time pass until the next one can be looked at."""
        await self.source.feed(RawVideo(self._pixels, "bgr24", 160, 120, 0, self.clock.now()))
        await settle()

    async def look(self) -> Sighting:
        """What is seen of one picture."""
        await self.show()
        async with asyncio.timeout(60):
            seen = await self.seen.get()
        await self.clock.advance(1 / RATE)
        return seen

    async def until_person(self) -> Sighting:
        while not (seen := await self.look()).persons:
            pass
        return seen


def counting(watch: Watch) -> tuple[PersonDetection, list[int]]:
    """A component that counts, and the numbers it notifies."""
    told: list[int] = []

    def tell(number: int, timestamp: datetime | None = None) -> None:
        told.append(number)

    detection = PersonDetection(watch)
    detection.person_detected = tell  # type: ignore[method-assign]
    return detection, told


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    await settle()
    yield stage
    stage.running.cancel()
    with suppress(asyncio.CancelledError):
        await stage.running
    assert stage.source.opened == stage.source.closed


async def test_camera_is_read_only_while_a_sense_is_active(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    await settle()
    assert stage.source.opened == 0
    stage.activity.start()
    await settle()
    assert stage.source.opened == 1
    seen = await stage.until_person()
    assert [person.number for person in seen.persons] == [1]
    assert stage.watch.figures.analysed >= 1
    assert 0 < stage.watch.figures.seconds < 60
    stage.activity.stop()
    await settle()
    assert (stage.source.opened, stage.source.closed) == (1, 1)
    assert stage.seen.get_nowait().persons == ()
    assert stage.seen.empty()
    assert stage.clock.sleepers == 0
    stage.activity.start()
    await settle()
    seen = await stage.until_person()
    assert [person.number for person in seen.persons] == [2]


async def test_pictures_that_come_too_fast_are_lost_but_for_the_newest(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    first = await stage.look()
    stage.finder.does = lambda: None
    for _ in range(5):
        await stage.show()
        await stage.clock.advance(0.01)
    async with asyncio.timeout(60):
        second = await stage.seen.get()
    assert second.moment > first.moment
    await stage.clock.advance(0.03)
    for _ in range(3):
        await stage.show()
        await stage.clock.advance(0.01)
    await stage.clock.advance(1 / RATE)
    async with asyncio.timeout(60):
        third = await stage.seen.get()
    assert third.moment - second.moment > 0.05
    assert stage.seen.empty()


async def test_no_person_is_seen_without_pictures(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    await stage.until_person()
    stage.camera.inlet.unplug("s")
    await stage.clock.advance(3 * BLIND)
    assert stage.seen.get_nowait().persons == ()
    stage.camera.inlet.plug("t", stage.source)
    await settle()
    await stage.until_person()


@pytest.mark.parametrize("others", [False, True])
async def test_camera_that_ended_during_a_pause_leaves_no_person_behind(stage: Stage, others: bool) -> None:
    detection, told = counting(stage.watch)
    stage.camera.inlet.plug("s", stage.source)
    await detection.start()
    if others:
        stage.activity.start()
    await settle()
    await stage.until_person()
    await detection.suspend()
    stage.camera.inlet.unplug("s")
    await stage.clock.advance(3 * BLIND)
    await detection.resume()
    await settle()
    assert told == [1]
    await stage.clock.advance(6 * BLIND)
    assert told == [1, 0]


async def test_analysis_that_fails_after_a_pause_leaves_no_person_behind(stage: Stage) -> None:
    detection, told = counting(stage.watch)
    stage.camera.inlet.plug("s", stage.source)
    await detection.start()
    await settle()
    await stage.until_person()
    await detection.suspend()
    await settle()

    def fail() -> None:
        raise ArithmeticError("a bug")

    stage.finder.does = fail
    await detection.resume()
    await settle()
    assert (await stage.look()).persons == ()
    while not stage.watch.failure:
        await stage.look()
    assert told == [1, 0]


async def test_likenesses_are_given_while_they_are_collected(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    assert (await stage.until_person()).persons[0].likeness is None
    with stage.watch.collecting():
        assert (await stage.look()).persons[0].likeness is not None
        stage.activity.stop()
        await settle()
        assert (await stage.look()).persons[0].likeness is not None
    await settle()
    assert stage.source.opened == stage.source.closed


async def test_failure_of_a_backend_is_reported_and_tried_again(stage: Stage, caplog: pytest.LogCaptureFixture) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    await stage.until_person()

    def fail() -> None:
        raise ArithmeticError("a bug")

    stage.finder.does = fail
    assert (await stage.look()).persons == ()
    assert "a bug" in stage.watch.failure
    assert "cannot be analysed" in caplog.text
    stage.finder.does = lambda: None
    await stage.clock.advance(1.0)
    await stage.until_person()
    assert stage.watch.failure == ""


async def test_failure_of_a_backend_ends_with_the_pictures_of_that_camera(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    await stage.until_person()

    def fail() -> None:
        raise ArithmeticError("a bug")

    stage.finder.does = fail
    await stage.look()
    stage.camera.inlet.unplug("s")
    await settle()
    assert "a bug" in stage.watch.failure
    await stage.clock.advance(2 * BLIND)
    assert stage.watch.failure == ""


async def test_a_backend_that_does_not_return_is_given_up(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_body.vision.watch.PATIENCE", 0.01)
    ends = asyncio.Event()
    loop = asyncio.get_running_loop()
    stage.finder.does = lambda: asyncio.run_coroutine_threadsafe(ends.wait(), loop).result(10)
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    await stage.show()
    # `run` ends by itself then.
    await asyncio.wait_for(asyncio.shield(stage.running), 10)
    assert "has not returned" in stage.watch.failure
    assert (stage.watch.figures.analysed, stage.watch.figures.failed) == (0, 1)
    await settle()
    assert stage.source.opened == stage.source.closed
    ends.set()


async def test_where_nothing_can_be_seen_from_the_beginning_nothing_is_tried() -> None:
    stage = Stage()
    stage.running.cancel()
    watch = Watch(stage.camera, stage.clock, stage.analysis, "install something")
    watch.serve(stage.activity)
    stage.activity.start()
    await watch.run()
    assert watch.failure == "install something"


async def test_while_the_analysis_hangs_nothing_piles_up_behind_it(
    stage: Stage, monkeypatch: pytest.MonkeyPatch
) -> None:
    submitted, go_on, entered = list[object](), threading.Event(), threading.Event()
    submit = ThreadPoolExecutor.submit

    def count(executor: ThreadPoolExecutor, *what: Any) -> Any:
        if executor._thread_name_prefix == "vision":
            submitted.append(what)
        return submit(executor, *what)

    monkeypatch.setattr(ThreadPoolExecutor, "submit", count)

    def hang() -> None:
        entered.set()
        go_on.wait(30)

    stage.finder.does = hang
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    await stage.show()
    await asyncio.to_thread(entered.wait, 30)
    for _ in range(20):
        stage.activity.stop()
        await settle()
        stage.activity.start()
        await settle()
        await stage.show()
    assert len(submitted) == 1
    stage.finder.does = lambda: None
    go_on.set()
    assert (await stage.until_person()).persons
    assert stage.watch.failure == ""


async def test_persons_are_on_the_floor_and_stay_where_they_were_while_the_camera_turns_away(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    stage.at = Place(1.0, 2.0, 0.0)
    (there,) = (await stage.until_person()).persons
    assert (there.place.x, there.place.y) == pytest.approx((1.325, 2.0), abs=0.1), "ahead of the camera"
    stage.finder.face = None
    while (seen := await stage.look()).persons[0].face:
        there = seen.persons[0]
    stage.at = Place(1.0, 2.0, math.pi)
    assert (await stage.look()).persons[0].place == there.place
    while (await stage.look()).persons:
        pass


async def test_a_person_is_told_once_it_is_known_where_the_camera_is(stage: Stage) -> None:
    stage.camera.inlet.plug("s", stage.source)
    stage.activity.start()
    await settle()
    stage.at = None
    for _ in range(5):
        assert (await stage.look()).persons == ()
    stage.at = Place(0.0, 0.0, 0.0)
    assert len((await stage.look()).persons) == 1
