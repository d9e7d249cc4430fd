"""Navigation over an engine whose figure walks by kinematics."""

import asyncio
import json
from math import dist
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.messages import Floor, Halt, Place, Thing, Walk
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import NoWay, plan
from openrois_body.motion.targets import Position
from openrois_body.motion.wayfinding import BODY, Ways
from openrois_body.motion.world import World

from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed, RoISError, TimedOut
from openrois.types.messages import Argument, Result
from tests.support.floors import SQUARE, Point, floors, points, rectangle, room_along
from tests.support.streaming import settle
from tests.support.walker import Walking

REF = "avatar/navigation"
WALL = rectangle(-3, 0.9, 3, 1.1)


class Stage(Walking):
    def __init__(self) -> None:
        super().__init__()
        self.registry = LocalRegistry("avatar", self.components)
        self.reached: list[tuple[str, bool]] = []
        self.navigation.emit = self._hear

    def _hear(self, _event: str, results: tuple[Result, ...]) -> None:
        values = {result.name: result.value for result in results}
        self.reached.append((values["target"], values["is_final_target"] == "true"))

    async def set(self, **values: Any) -> None:
        arguments = tuple(
            Argument(name=name, data_type_ref="", value=value if isinstance(value, str) else json.dumps(value))
            for name, value in values.items()
        )
        await self.registry.invoke(REF, "set_parameter", arguments)

    async def begin(self, **values: Any) -> "asyncio.Future[Any]":
        await self.set(**values)
        running = asyncio.ensure_future(self.registry.invoke(REF, "start"))
        await settle()
        return running

    async def command(self, name: str) -> None:
        await self.registry.invoke(REF, name)

    @property
    def at(self) -> Point:
        return self.engine.x, self.engine.y


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def test_targets_are_reached_in_turn_and_told(stage: Stage) -> None:
    running = await stage.begin(target_positions=["1,0", "1,1,3.0", "0,1"])
    await stage.run_until(running)
    assert await running == ()
    assert stage.reached == [("1,0", False), ("1,1,3.0", False), ("0,1", True)]
    assert stage.at == pytest.approx((0, 1))
    assert sum(isinstance(each, Walk) for each in stage.engine.heard) == 1


async def test_a_position_with_an_angle_ends_in_that_direction(stage: Stage) -> None:
    running = await stage.begin(target_positions=["1,0,-1.5"])
    await stage.run_until(running)
    assert stage.engine.th == pytest.approx(-1.5)


async def test_obstacles_are_walked_round(stage: Stage) -> None:
    floor = Floor(SQUARE, (WALL,))
    stage.build(floor)
    running = await stage.begin(target_positions=["0,2"], routing_policy="distance")
    await stage.run_until(running)
    assert stage.at == pytest.approx((0, 2))
    assert room_along(floor, stage.engine.track) >= BODY - 1e-3


@pytest.mark.parametrize("target", ["0,2", "Anna"])
@pytest.mark.parametrize(
    ("values", "to_the_right"),
    [({}, True), ({"routing_policy": "time"}, True), ({"routing_policy": "distance"}, False)],
)
async def test_the_fastest_way_is_not_the_shortest(
    stage: Stage, target: str, values: dict[str, str], to_the_right: bool
) -> None:
    stage.build(Floor(SQUARE, (rectangle(-2.9, 0.9, 3, 1.1),)))
    stage.populate(Thing("p", "person", 0, 2, name="Anna"))
    await stage.begin(target_positions=[target], **values)
    walk = stage.engine.heard[-1]
    assert isinstance(walk, Walk)
    assert (walk.path[0].x > 0) is to_the_right, "it faces to the right, and would have to turn"
    assert walk.speed == 1


async def test_each_way_begins_where_the_one_before_ends(stage: Stage) -> None:
    floor = Floor(SQUARE, (WALL,))
    stage.build(floor)
    running = await stage.begin(target_positions=["4,0", "4,2", "-4,2", "-4,0"])
    await stage.run_until(running)
    assert room_along(floor, stage.engine.track) >= BODY - 1e-3


async def test_a_person_is_walked_up_to_and_looked_at(stage: Stage) -> None:
    stage.build(Floor(SQUARE, ()))
    stage.populate(Thing("p", "person", 3, 0, name="Anna"))
    running = await stage.begin(target_positions=["Anna"])
    await stage.run_until(running)
    assert stage.reached == [("Anna", True)]
    assert dist(stage.at, (3, 0)) == pytest.approx(0.8, abs=0.01)
    assert stage.engine.th == pytest.approx(0, abs=0.01)


async def test_another_floor_under_way_is_planned_for(stage: Stage) -> None:
    running = await stage.begin(target_positions=["0,0.5", "0,2"])
    await stage.run(1)
    floor = Floor(SQUARE, (WALL,))
    stage.build(floor)
    track = stage.engine.track = [stage.at]
    await stage.run_until(running)
    assert stage.reached == [("0,0.5", False), ("0,2", True)]
    assert stage.at == pytest.approx((0, 2))
    assert room_along(floor, track) >= BODY - 1e-3
    assert stage.engine.heard.count(Halt()) == 0, "a way over a small floor is found as it goes"


async def test_a_target_that_a_new_floor_shuts_off_fails_by_its_name(stage: Stage) -> None:
    running = await stage.begin(target_positions=["0,3"])
    await stage.run(1)
    stage.build(Floor(SQUARE, (rectangle(-7, 0.9, 7, 1.1),)))
    await settle()
    with pytest.raises(ComponentFailed, match="'0,3' cannot be reached"):
        await running
    assert isinstance(stage.engine.heard[-1], Halt)
    assert not stage.engine.moves


@pytest.mark.parametrize(
    ("target", "why"),
    [("9,0", "'9,0' is outside of the floor"), ("0,1", "inside an obstacle"), ("0,1.3", "is only 0.20 m from an edge")],
)
async def test_unreachable_target_fails_before_the_first_step(stage: Stage, target: str, why: str) -> None:
    stage.build(Floor(SQUARE, (WALL,)))
    running = await stage.begin(target_positions=["1,0", target])
    with pytest.raises(ComponentFailed, match=why):
        await running
    assert stage.engine.heard == []


async def test_a_walk_that_the_engine_breaks_off_goes_on(stage: Stage) -> None:
    running = await stage.begin(target_positions=["2,0"])
    for _ in range(2):
        await stage.run(1)
        stage.engine.break_off()
    await stage.run_until(running)
    assert stage.at == pytest.approx((2, 0))


async def test_walk_aborted_repeatedly_fails(stage: Stage) -> None:
    running = await stage.begin(target_positions=["2,0"])
    for _ in range(3):
        stage.engine.break_off()
        await stage.run(0.6)
    with pytest.raises(ComponentFailed, match="'2,0': the body broke the motion off 3 times"):
        await running


async def test_walk_that_the_engine_refuses_fails(stage: Stage) -> None:
    running = await stage.begin(target_positions=["2,0"])
    stage.engine.refuse()
    with pytest.raises(ComponentFailed, match="the body cannot go there"):
        await running


async def test_time_is_limited(stage: Stage) -> None:
    running = await stage.begin(target_positions=["5,0"], time_limit="2000")
    await stage.run(1.95)
    assert not running.done()
    await stage.run(0.1)
    with pytest.raises(TimedOut, match="navigation took longer than 2000 ms"):
        await running
    assert not stage.engine.moves


async def test_suspended_it_stands_and_its_time_stands_too(stage: Stage) -> None:
    running = await stage.begin(target_positions=["3,0"], time_limit="4500")
    await stage.run(1)
    await stage.command("suspend")
    await stage.command("suspend")
    at = stage.at
    await stage.run(60)
    assert stage.at == at
    assert not running.done()
    await stage.command("resume")
    await stage.command("resume")
    await stage.run_until(running, 3.4)
    assert await running == ()
    assert stage.at == pytest.approx((3, 0))


async def test_time_runs_out_after_a_pause(stage: Stage) -> None:
    running = await stage.begin(target_positions=["5,0"], time_limit="2000")
    await stage.run(1)
    await stage.command("suspend")
    await stage.run(5)
    await stage.command("resume")
    await stage.run(0.9)
    assert not running.done()
    await stage.run(0.2)
    with pytest.raises(TimedOut):
        await running


async def test_component_that_does_not_run_cannot_be_suspended(stage: Stage) -> None:
    for _ in range(2):
        await stage.command("suspend")
        running = await stage.begin(target_positions=["1,0", "0,0"])
        await stage.run_until(running)
        await running
        await stage.command("resume")


async def test_a_pause_is_not_counted_in_another_run(stage: Stage) -> None:
    running = await stage.begin(target_positions=["3,0"], time_limit="2000")
    await stage.command("suspend")
    await stage.run(5)
    await stage.command("resume")
    await stage.command("stop")
    with pytest.raises(Aborted):
        await running
    await test_time_is_limited(stage)


async def test_stop_halts_it_at_once_also_while_it_is_suspended(stage: Stage) -> None:
    for pause in (False, True):
        running = await stage.begin(target_positions=["5,0"])
        await stage.run(0.5)
        if pause:
            await stage.command("suspend")
        await stage.command("stop")
        with pytest.raises(Aborted):
            await running
        assert not stage.engine.moves


async def test_a_new_start_goes_elsewhere(stage: Stage) -> None:
    first = await stage.begin(target_positions=["5,0"])
    await stage.run(1)
    second = await stage.begin(target_positions=["0,-1"])
    with pytest.raises(Aborted):
        await first
    await stage.run_until(second)
    assert stage.at == pytest.approx((0, -1))


async def test_a_move_ends_it_and_it_says_why(stage: Stage) -> None:
    running = await stage.begin(target_positions=["5,0"])
    await stage.registry.invoke(
        "avatar/move", "set_parameter", (Argument(name="line", data_type_ref="int[]", value="[100,0]"),)
    )
    moving = asyncio.ensure_future(stage.registry.invoke("avatar/move", "start"))
    await settle()
    with pytest.raises(Aborted, match="navigation was ended: move has the body now"):
        await running
    await stage.run_until(moving)


async def test_a_lost_engine_fails_it_and_the_component_says_so(stage: Stage) -> None:
    running = await stage.begin(target_positions=["5,0"])
    stage.lose()
    with pytest.raises(ComponentFailed, match="the body is disconnected"):
        await running
    with pytest.raises(ComponentFailed, match="does not work now"):
        await stage.command("start")
    assert (await stage.registry.query(REF, "component_status"))[0].value == "ERROR"
    stage.engine.connected = True
    with pytest.raises(ComponentFailed, match="does not work now"):
        await stage.command("start")
    assert (await stage.registry.query(REF, "component_status"))[0].value == "ERROR", "its place is not known"
    stage.engine.tell_place()
    assert (await stage.registry.query(REF, "component_status"))[0].value == "READY"
    await stage.run_until(await stage.begin(target_positions=["1,0"]))


async def test_an_engine_that_goes_while_a_way_is_planned_has_told_of_no_place(stage: Stage) -> None:
    stage.world.clear()
    with pytest.raises(ComponentFailed, match="the body has not reported where it is"):
        stage.navigation.figure.place()


async def test_an_engine_without_a_figure_that_walks_is_an_error(stage: Stage) -> None:
    stage.engine.walks = False
    assert (await stage.registry.query(REF, "component_status"))[0].value == "ERROR"


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"target_positions": []}, "expected 1 to 100"),
        ({"target_positions": ["1,0", "Bob"]}, "'Bob' is not in the scene"),
        ({"time_limit": "-1"}, "time_limit"),
        ({"routing_policy": "fun"}, "routing_policy"),
    ],
)
async def test_parameters_that_cannot_be_used_are_refused(stage: Stage, values: dict[str, Any], why: str) -> None:
    with pytest.raises(BadParameter, match=why):
        await stage.set(**values)
    with pytest.raises(BadParameter, match="target_positions is not set; set it before start"):
        await stage.command("start")


async def test_person_that_left_the_scene_is_no_target(stage: Stage) -> None:
    stage.populate(Thing("p", "person", 1, 0))
    await stage.set(target_positions=["p"])
    stage.populate()
    with pytest.raises(BadParameter, match="'p' is not in the scene"):
        await stage.command("start")


POSTS = tuple(rectangle(x, -2, x + 0.1, -1) for x in range(-5, 5))


async def until_it_walks(stage: Stage, running: "asyncio.Future[Any]") -> None:
    async with asyncio.timeout(60):
        while not stage.engine.moves:
            await asyncio.wait({running}, timeout=0.001)


async def test_a_large_floor_is_planned_beside_the_loop_and_again_if_it_changes(stage: Stage) -> None:
    stage.build(Floor(SQUARE, POSTS))
    running = await stage.begin(target_positions=["0.5,3"])
    floor = Floor(SQUARE, (*POSTS, WALL))
    stage.build(floor)
    await until_it_walks(stage, running)
    await stage.run_until(running)
    assert room_along(floor, stage.engine.track) >= BODY - 1e-3


async def test_a_floor_that_changes_faster_than_it_is_planned_for_is_given_up(stage: Stage) -> None:
    ways, planned = Ways(stage.world), 0

    def floor(number: int) -> Floor:
        return Floor(SQUARE, (*POSTS, rectangle(-3, 0.9, 3, 1.1 + number / 1000)))

    class Restless(World):
        """Another floor at each look."""

        @property
        def floor(self) -> Floor | None:
            nonlocal planned
            planned += 1
            return floor(planned)

        @floor.setter
        def floor(self, _floor: Floor | None) -> None: ...

    ways = Ways(Restless("avatar"))
    with pytest.raises(NoWay, match="the floor changes faster than a way is planned"):
        await ways.to(Place(0, 0, 0), Position(0.5, 3), "time")
    assert planned < 20


async def test_figure_stands_while_a_large_floor_is_planned(stage: Stage) -> None:
    stage.build(Floor(SQUARE, POSTS))
    running = await stage.begin(target_positions=["0.5,3"])
    await until_it_walks(stage, running)
    stage.build(Floor(SQUARE, (*POSTS, WALL)))
    assert isinstance(stage.engine.heard[-1], Halt)
    await stage.command("stop")
    with pytest.raises(Aborted):
        await running


async def test_suspended_while_it_plans_it_does_not_begin(stage: Stage) -> None:
    stage.build(Floor(SQUARE, POSTS))
    running = await stage.begin(target_positions=["0.5,0"])
    await stage.command("suspend")
    stage.engine.heard.clear()
    ways = Ways(stage.world)
    await ways.to(Place(0, 0, 0), Position(0.5, 0), "time")
    await settle()
    assert not [each for each in stage.engine.heard if isinstance(each, Walk)]
    await stage.command("resume")
    await until_it_walks(stage, running)
    await stage.run_until(running)


@given(floors(3), points(), points(), st.sampled_from(["time", "distance"]))
@settings(max_examples=25, deadline=None)
def test_on_any_floor_it_arrives_or_says_why(floor: Floor, first: Point, goal: Point, policy: Any) -> None:
    async def navigate() -> None:
        stage = Stage()
        stage.engine.x, stage.engine.y = first
        stage.engine.track = [first]
        stage.engine.tell_place()
        stage.build(floor)
        running = await stage.begin(target_positions=[f"{goal[0]!r},{goal[1]!r}"], routing_policy=policy)
        ground, place = Ground(floor, BODY), stage.world.place
        assert place is not None
        start = place.x, place.y
        try:
            plan(ground, start, place.th, goal, policy)
        except NoWay:
            with pytest.raises(RoISError, match=r"cannot be reached|is outside|is only"):
                await running
            return
        await stage.run_until(running)
        await running
        assert stage.at == pytest.approx(goal, abs=1e-3)
        if ground.clear_at(start):
            assert room_along(floor, stage.engine.track, 0.05) >= BODY - 2e-3

    asyncio.run(navigate())
