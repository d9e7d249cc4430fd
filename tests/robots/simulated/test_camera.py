"""The robot's camera as a source: it draws while it is watched, and only then."""

import asyncio
from collections.abc import AsyncIterator

import pytest
from openrois_body.messages import Place
from openrois_robots.simulated.camera import FRAME_RATE, SIZE, RobotCamera
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.world.plan import APARTMENT
from openrois_streaming.source.source import RawVideo

from tests.support.streaming import VirtualClock, settle

pytestmark = pytest.mark.extra(name="robot")

WIDTH, HEIGHT = SIZE


class Stage:
    """A camera that looks one tenth of a radian further with each picture."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.looked: list[float] = []
        self.failure: Exception | None = None
        self.camera = RobotCamera(APARTMENT, self._look, self.clock)

    def _look(self) -> View:
        if self.failure is not None:
            raise self.failure
        self.looked.append(self.clock.now())
        return View(Place(-2.0, -0.5, 0.1 * len(self.looked)))

    async def next(self, pictures: AsyncIterator[RawVideo]) -> RawVideo:
        """Let the clock go on until there is a picture: drawing takes a thread, and none of its time."""
        return (await self.next_of(pictures))[0]

    async def next_of(self, *readers: AsyncIterator[RawVideo]) -> list[RawVideo]:
        """Do that for several readers, which all wait before the clock goes on."""
        coming = [asyncio.ensure_future(anext(pictures)) for pictures in readers]
        await settle()
        while not all(each.done() for each in coming):
            if self.clock.sleepers:
                await self.clock.advance(1 / FRAME_RATE)
            await asyncio.wait(coming, timeout=0.001)
        return [each.result() for each in coming]


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    made = Stage()
    async with made.camera:
        yield made


async def test_without_a_viewer_nothing_is_looked_at_or_drawn(stage: Stage) -> None:
    await stage.clock.advance(10)
    assert (stage.looked, stage.camera.drawn, stage.clock.sleepers) == ([], 0, 0)


async def test_pictures_show_the_moment_they_say(stage: Stage) -> None:
    async with stage.camera.open() as pictures:
        first, second = await stage.next(pictures), await stage.next(pictures)
    assert [first.captured_at, second.captured_at] == stage.looked[:2]
    assert second.captured_at - first.captured_at == pytest.approx(1 / FRAME_RATE)
    assert second.sequence == first.sequence + 1
    assert (first.width, first.height, first.format) == (WIDTH, HEIGHT, "bgra")
    assert first.data.std() > 10, "there is something to see"
    assert (first.data != second.data).any()
    views = [stage.camera.view_at(each.captured_at) for each in (first, second)]
    assert [view.camera.th for view in views if view] == pytest.approx([0.1, 0.2])
    assert stage.camera.view_at(first.captured_at - 1) is None


async def test_after_the_last_viewer_nothing_is_drawn(stage: Stage) -> None:
    async with stage.camera.open() as pictures:
        await stage.next(pictures)
    drawn, looked = stage.camera.drawn, len(stage.looked)
    await stage.clock.advance(10)
    assert (stage.camera.drawn, len(stage.looked)) == (drawn, looked)
    async with stage.camera.open() as pictures:
        assert (await stage.next(pictures)).sequence == drawn + 1, "and it can be opened again"


async def test_two_viewers_share_the_pictures(stage: Stage) -> None:
    async with stage.camera.open() as one, stage.camera.open() as other:
        first, again = await stage.next_of(one, other)
    assert first is again
    assert len(stage.looked) - stage.camera.drawn <= 1, "each picture is looked at once; one may be under way"


async def test_pictures_that_came_late_are_not_made_up_for(stage: Stage) -> None:
    async with stage.camera.open() as pictures:
        await stage.next(pictures)
        stage.clock.jump(5)
        before = stage.camera.drawn
        for _ in range(4):
            late = await stage.next(pictures)
        assert late.sequence <= before + 5
        assert late.captured_at > 1005.0


async def test_a_failure_reaches_the_viewer(stage: Stage) -> None:
    stage.failure = RuntimeError("Panda3D cannot draw here")
    with pytest.raises(RuntimeError, match="cannot draw here"):
        async with stage.camera.open() as pictures:
            await anext(pictures)
