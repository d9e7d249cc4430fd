"""Follow over an engine whose figure walks by kinematics."""

import asyncio
from math import atan2, cos, dist, radians, sin
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.messages import Floor, Place, Thing, Walk, Waypoint
from openrois_body.messages.motion import Kind
from openrois_body.motion.planning import Policy
from openrois_body.motion.wayfinding import BODY

from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, TimedOut
from openrois.types.messages import Argument
from tests.support.floors import SQUARE, floors, rectangle, room_along
from tests.support.streaming import settle
from tests.support.walker import STEP, Walking

REF = "avatar/follower"
ANNA = "urn:x-rois:def:person:OpenRoIS::avatar/scene/anna"


class Stage(Walking):
    def __init__(self) -> None:
        super().__init__()
        self.registry = LocalRegistry("avatar", self.components)
        self.anna = 3.0, 0.0
        self.show()

    def show(self) -> None:
        self.populate(Thing("anna", "person", *self.anna))

    async def anna_goes(self, x: float, y: float, seconds: float) -> None:
        """Let her walk, telling her place ten times a second."""
        for turn in range(round(seconds / STEP)):
            self.anna = self.anna[0] + x * STEP, self.anna[1] + y * STEP
            if turn % 2:
                self.show()
            await self.run(STEP)

    async def set(self, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="", value=value) for name, value in values.items())
        await self.registry.invoke(REF, "set_parameter", arguments)

    async def begin(self, distance: int = 1000, **values: str) -> "asyncio.Future[Any]":
        await self.set(target_object_ref=ANNA, distance=str(distance), **values)
        running = asyncio.ensure_future(self.registry.invoke(REF, "start"))
        await settle()
        return running

    async def stop(self, running: "asyncio.Future[Any]") -> None:
        await self.registry.invoke(REF, "stop")
        with pytest.raises(Aborted):
            await running
        assert not self.engine.moves

    @property
    def walks(self) -> list[Walk]:
        """What the engine was asked for."""
        return [each for each in self.engine.heard if isinstance(each, Walk)]

    def anna_stands(self, x: float, y: float) -> None:
        self.anna = x, y
        self.show()

    @property
    def away(self) -> float:
        return dist((self.engine.x, self.engine.y), self.anna)


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def test_figure_follows_the_target_until_stop(stage: Stage) -> None:
    running = await stage.begin()
    await stage.run(5)
    assert stage.away == pytest.approx(1, abs=0.02)
    await stage.anna_goes(0.8, 0.4, 8)
    assert stage.away < 1.5
    await stage.run(3)
    assert stage.away == pytest.approx(1, abs=0.12)
    await stage.stop(running)


async def test_figure_within_the_distance_waits_and_faces_the_target(stage: Stage) -> None:
    running = await stage.begin(5000)
    await stage.run(1)
    assert not stage.walks
    stage.anna_stands(0.0, 2.0)
    await stage.run(2)
    assert (stage.engine.x, stage.engine.y) == (0, 0)
    assert stage.engine.th == pytest.approx(1.5708, abs=1e-3)
    await stage.stop(running)


@pytest.mark.parametrize(("degrees", "turns"), [(28, False), (30, True)])
async def test_standing_figure_turns_after_a_target_that_leaves_its_sight(
    stage: Stage, degrees: float, turns: bool
) -> None:
    running = await stage.begin(5000)
    stage.anna_stands(3 * cos(radians(degrees)), 3 * sin(radians(degrees)))
    await stage.run(1)
    assert stage.engine.th == pytest.approx(radians(degrees) if turns else 0, abs=1e-3)
    await stage.stop(running)


@pytest.mark.parametrize(("metres", "walks"), [(0.14, 1), (0.16, 2)])
async def test_way_is_planned_again_when_the_target_has_moved_by_15_cm(stage: Stage, metres: float, walks: int) -> None:
    running = await stage.begin()
    stage.anna_stands(3.0 + metres, 0)
    await settle()
    assert [walk.speed for walk in stage.walks] == [1.5] * walks
    await stage.stop(running)


@pytest.mark.parametrize(("metres", "walks"), [(0.08, 0), (0.12, 1)])
async def test_less_than_10_cm_are_not_worth_a_step(stage: Stage, metres: float, walks: int) -> None:
    running = await stage.begin(3000)
    stage.anna_stands(3.0 + metres, 0)
    await settle()
    assert len(stage.walks) == walks
    await stage.stop(running)


@pytest.mark.parametrize(("kind", "away"), [("person", 0.6), ("object", 0.25), ("sound", 0.25)])
async def test_figure_leaves_room_for_two_bodies(stage: Stage, kind: Kind, away: float) -> None:
    stage.populate(Thing("it", kind, *stage.anna))
    await stage.set(target_object_ref="it", distance="250")
    running = asyncio.ensure_future(stage.registry.invoke(REF, "start"))
    await stage.run(5)
    assert stage.away == pytest.approx(away, abs=0.02)
    await stage.stop(running)


async def test_figure_walks_round_obstacles(stage: Stage) -> None:
    floor = Floor(SQUARE, (rectangle(1, -3, 1.2, 3),))
    stage.build(floor)
    running = await stage.begin()
    await stage.run(9)
    assert stage.away == pytest.approx(1, abs=0.02)
    assert room_along(floor, stage.engine.track) >= BODY - 1e-3
    await stage.stop(running)


async def test_figure_that_has_arrived_faces_the_target(stage: Stage) -> None:
    stage.build(Floor(SQUARE, (rectangle(1, -3, 1.2, -0.1),)))
    running = await stage.begin(2100)
    await stage.run(5)
    assert stage.engine.x == pytest.approx(0.9, abs=0.05), "on its way round the corner, where it looks past her"
    assert stage.engine.th == pytest.approx(atan2(-stage.engine.y, 3 - stage.engine.x), abs=1e-3)
    await stage.stop(running)


async def test_following_goes_on_when_the_target_comes_back(stage: Stage) -> None:
    running = await stage.begin()
    await stage.run(0.5)
    stage.populate()
    await stage.run(0.1)
    at = stage.engine.x
    await stage.run(4)
    assert stage.engine.x == at
    stage.show()
    await stage.run(5)
    assert stage.away == pytest.approx(1, abs=0.02)
    stage.populate()
    await stage.run(4)
    assert not running.done()
    await stage.run(1.1)
    with pytest.raises(ComponentFailed, match="is not in the scene, for 5 s"):
        await running


async def test_whom_it_cannot_reach_for_five_seconds_it_gives_up(stage: Stage) -> None:
    stage.build(Floor(SQUARE, (rectangle(1, -7, 1.2, 7),)))
    running = await stage.begin()
    await stage.run(4.9)
    assert not running.done()
    await stage.run(0.2)
    with pytest.raises(ComponentFailed, match="cannot be reached: obstacles are all around it"):
        await running


async def test_target_in_an_obstacle_is_followed_up_to_it(stage: Stage) -> None:
    stage.build(Floor(SQUARE, (rectangle(2.5, -0.5, 3.5, 0.5),)))
    running = await stage.begin(100)
    await stage.run(6)
    assert stage.away == pytest.approx(0.5 + BODY, abs=0.02), "nearer than that there is no room"
    await stage.stop(running)


async def test_another_floor_is_planned_for(stage: Stage) -> None:
    running = await stage.begin()
    await stage.run(0.3)
    floor = Floor(SQUARE, (rectangle(1, -3, 1.2, 3),))
    stage.build(floor)
    track = stage.engine.track = [(stage.engine.x, stage.engine.y)]
    await stage.run(9)
    assert room_along(floor, track) >= BODY - 1e-3
    assert stage.away == pytest.approx(1, abs=0.02)
    await stage.stop(running)


async def test_its_time_is_limited(stage: Stage) -> None:
    running = await stage.begin(time_limit="3000")
    await stage.run(3.1)
    with pytest.raises(TimedOut, match="follower took longer than 3000 ms"):
        await running


async def test_suspended_it_stands(stage: Stage) -> None:
    running = await stage.begin()
    await stage.run(0.5)
    await stage.registry.invoke(REF, "suspend")
    at = stage.engine.x
    await stage.anna_goes(0.5, 0, 3)
    assert stage.engine.x == at
    await stage.registry.invoke(REF, "resume")
    await stage.run(5)
    assert stage.away == pytest.approx(1, abs=0.02)
    await stage.stop(running)


async def test_walks_that_the_engine_breaks_off_are_tried_again_and_not_for_ever(stage: Stage) -> None:
    running = await stage.begin()
    stage.engine.break_off()
    await stage.run(0.4)
    assert not stage.engine.moves
    await stage.run(0.3)
    assert stage.engine.moves
    for _ in range(2):
        stage.engine.break_off()
        await stage.run(0.6)
    assert running.done()
    with pytest.raises(ComponentFailed, match="broke the motion off 3 times"):
        await running


async def test_completed_walk_resets_the_count_of_aborted_ones(stage: Stage) -> None:
    running = await stage.begin()
    for x in (3.0, 5.0, 7.0):
        stage.anna_stands(x, 0)
        await settle()
        for _ in range(2):
            stage.engine.break_off()
            await stage.run(0.6)
        await stage.run(3)
    assert stage.away == pytest.approx(1, abs=0.02)
    await stage.stop(running)


async def test_suspended_while_it_plans_it_does_not_begin(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = asyncio.Event()
    plan = stage.follow.figure.ways.to_within

    async def later(start: Place, thing: Thing, metres: float, policy: Policy) -> list[Waypoint]:
        await gate.wait()
        return await plan(start, thing, metres, policy)

    monkeypatch.setattr(stage.follow.figure.ways, "to_within", later)
    running = await stage.begin()
    await stage.registry.invoke(REF, "suspend")
    gate.set()
    await settle()
    assert not stage.walks
    await stage.registry.invoke(REF, "resume")
    await settle()
    assert stage.walks
    await stage.stop(running)


async def test_a_lost_engine_fails_it_also_while_it_stands(stage: Stage) -> None:
    running = await stage.begin(5000)
    stage.lose()
    with pytest.raises(ComponentFailed, match="the body is disconnected"):
        await running


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"target_object_ref": "ben"}, "'ben' is not in the scene; there is 'anna'"),
        ({"distance": "-1"}, "distance"),
        ({"time_limit": "-1"}, "time_limit"),
    ],
)
async def test_unknown_target_is_refused(stage: Stage, values: dict[str, str], why: str) -> None:
    with pytest.raises(BadParameter, match=why):
        await stage.set(**values)
    with pytest.raises(BadParameter, match="set target_object_ref and distance first"):
        await stage.registry.invoke(REF, "start")


async def test_target_missing_at_the_start_is_not_waited_for(stage: Stage) -> None:
    await stage.set(target_object_ref=ANNA, distance="1000")
    stage.populate()
    with pytest.raises(BadParameter, match="is not in the scene"):
        await stage.registry.invoke(REF, "start")


@given(floors(2), st.floats(-3.1, 3.1))
@settings(max_examples=10, deadline=None)
def test_on_any_floor_it_keeps_clear_of_everything(floor: Floor, towards: float) -> None:
    async def follow() -> None:
        stage = Stage()
        stage.build(floor)
        running = await stage.begin(800)
        await stage.anna_goes(0.7 * cos(towards), 0.7 * sin(towards), 4)
        await stage.run(1)
        if room_along(floor, stage.engine.track[:1]) >= BODY:
            assert room_along(floor, stage.engine.track, 0.05) >= BODY - 2e-3
        running.cancel()
        await asyncio.wait({running})

    asyncio.run(follow())
