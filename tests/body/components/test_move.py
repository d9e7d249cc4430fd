"""Move over an engine whose figure walks by kinematics."""

import asyncio
from math import dist, pi, radians
from typing import Any

import pytest
from openrois_body.messages import Floor, Halt, Place, Walk, Waypoint

from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, BadParameter, ComponentFailed
from openrois.types.messages import Argument
from tests.support.floors import SQUARE, rectangle
from tests.support.streaming import settle
from tests.support.walker import Walking

REF = "avatar/move"
AHEAD = rectangle(1, -1, 1.2, 1)


class Stage(Walking):
    def __init__(self) -> None:
        super().__init__()
        self.registry = LocalRegistry("avatar", self.components)

    async def set(self, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="", value=value) for name, value in values.items())
        await self.registry.invoke(REF, "set_parameter", arguments)

    async def begin(self, **values: str) -> "asyncio.Future[Any]":
        await self.set(**values)
        running = asyncio.ensure_future(self.registry.invoke(REF, "start"))
        await settle()
        return running

    async def ends_at(self, running: "asyncio.Future[Any]", x: float, y: float, th: float) -> None:
        await self.run_until(running)
        await running
        assert (self.engine.x, self.engine.y) == pytest.approx((x, y), abs=1e-3)
        assert (self.engine.th - th) % (2 * pi) == pytest.approx(0, abs=1e-3) or (th - self.engine.th) % (
            2 * pi
        ) == pytest.approx(0, abs=1e-3)


@pytest.fixture
def stage() -> Stage:
    return Stage()


@pytest.mark.parametrize(
    ("name", "value", "end"),
    [
        ("line", "[1500,0]", (1.5, 0, 0)),
        ("line", "[500,90]", (0.5, 0, pi / 2)),
        ("line", "[0,-270]", (0, 0, pi / 2)),
        ("line", "[-500,0]", (-0.5, 0, 0)),
        ("curve", "[1000,90]", (1, 1, pi / 2)),
        ("curve", "[1000,-180]", (0, -2, pi)),
        ("curve", "[0,45]", (0, 0, pi / 4)),
    ],
)
async def test_figure_walks_the_set_line_or_curve(
    stage: Stage, name: str, value: str, end: tuple[float, float, float]
) -> None:
    await stage.ends_at(await stage.begin(**{name: value}), *end)


async def test_a_turn_of_three_quarters_goes_the_long_way(stage: Stage) -> None:
    running = await stage.begin(line="[0,-270]")
    await stage.run_until(running)
    assert stage.engine.th == pytest.approx(radians(-270), abs=1e-3)


async def test_backwards_it_looks_ahead(stage: Stage) -> None:
    running = await stage.begin(line="[-500,0]")
    await stage.run(0.3)
    assert stage.engine.th == 0
    assert stage.engine.x == pytest.approx(-0.3)
    await stage.run_until(running)


async def test_a_time_makes_it_as_fast(stage: Stage) -> None:
    running = await stage.begin(line="[2000,0]", time="4000")
    walk = stage.engine.heard[-1]
    assert isinstance(walk, Walk)
    assert walk.speed == 0.5
    await stage.run_until(running, 4.2)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"line": "[1000,0]", "curve": "[1000,90]"}, "line and curve cannot be set together; set one of them"),
        ({"line": "[1000]"}, "line: expected two numbers"),
        ({"curve": "[-1,90]"}, "the radius must be 0 mm or more, not -1"),
        ({"line": "[3000,0]", "time": "1000"}, "3.00 m in 1000 ms are 3 m/s; the speed must be between 0.01 and 2 m/s"),
        ({"curve": "[2000,180]", "time": "1000"}, "6.28 m in 1000 ms"),
        ({"time": "-1"}, "time"),
    ],
)
async def test_impossible_motion_is_refused(stage: Stage, values: dict[str, str], why: str) -> None:
    with pytest.raises(BadParameter, match=why.replace(".", r"\.")):
        await stage.set(**values)
    with pytest.raises(BadParameter, match="neither line nor curve is set; set one of them before start"):
        await stage.registry.invoke(REF, "start")


async def test_a_time_that_was_set_before_counts(stage: Stage) -> None:
    await stage.set(time="1000")
    with pytest.raises(BadParameter, match="3 m/s"):
        await stage.set(line="[3000,0]")
    await stage.set(line="[3000,0]", time="0")


async def test_last_set_motion_is_done(stage: Stage) -> None:
    await stage.set(line="[1000,0]")
    await stage.set(curve="[1000,90]")
    await stage.set(line="[500,0]")
    assert stage.move.curve is None
    await stage.ends_at(await stage.begin(), 0.5, 0, 0)
    await stage.ends_at(await stage.begin(curve="[0,90]"), 0.5, 0, pi / 2)


@pytest.mark.parametrize(("name", "value", "metres"), [("line", "[2000,0]", "0.75"), ("curve", "[1000,-90]", "0.8")])
async def test_obstacle_is_reported_before_the_first_step(stage: Stage, name: str, value: str, metres: str) -> None:
    stage.build(Floor(SQUARE, (AHEAD,)))
    with pytest.raises(ComponentFailed, match=f"move: an obstacle is in the way after {metres}"):
        await (await stage.begin(**{name: value}))
    assert stage.engine.heard == []


async def test_new_obstacle_stops_the_motion(stage: Stage) -> None:
    running = await stage.begin(line="[3000,0]")
    await stage.run(0.3)
    stage.build(Floor(SQUARE, ()))
    await stage.run(0.2)
    stage.build(Floor(SQUARE, (AHEAD,)))
    await settle()
    with pytest.raises(ComponentFailed, match="in the way"):
        await running
    assert stage.engine.x < 0.6
    assert not stage.engine.moves


async def test_figure_at_a_wall_can_turn_and_leave(stage: Stage) -> None:
    stage.build(Floor(SQUARE, (rectangle(0.1, -1, 0.2, 1),)))
    await stage.ends_at(await stage.begin(line="[0,180]"), 0, 0, pi)
    await stage.ends_at(await stage.begin(line="[1000,0]"), -1, 0, pi)


async def test_figure_in_an_obstacle_can_turn(stage: Stage) -> None:
    stage.build(Floor(SQUARE, (rectangle(-0.1, -1, 0.2, 1),)))
    await stage.ends_at(await stage.begin(line="[0,180]"), 0, 0, pi)
    with pytest.raises(ComponentFailed, match="the body stands in an obstacle"):
        await (await stage.begin(line="[1000,0]"))


async def test_a_time_that_the_body_is_too_slow_for_is_refused(stage: Stage) -> None:
    stage.move.figure.legs.top_speed = 0.5
    with pytest.raises(BadParameter, match=r"the speed must be between 0\.01 and 0\.5 m/s"):
        await stage.begin(line="[1000,0]", time="1000")


async def test_suspended_it_goes_on_where_it_was(stage: Stage) -> None:
    running = await stage.begin(curve="[1000,180]")
    await stage.run(1)
    await stage.registry.invoke(REF, "suspend")
    at = stage.engine.x
    await stage.run(10)
    assert stage.engine.x == at
    await stage.registry.invoke(REF, "resume")
    await stage.ends_at(running, 0, 2, pi)
    assert sum(map(dist, stage.engine.track, stage.engine.track[1:])) == pytest.approx(pi, abs=0.01)


async def test_suspended_while_it_looks_ahead_it_does_not_begin(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    gate = asyncio.Event()
    check = stage.move.figure.ways.check

    async def later(start: Place, path: list[Waypoint]) -> None:
        await gate.wait()
        await check(start, path)

    monkeypatch.setattr(stage.move.figure.ways, "check", later)
    running = await stage.begin(line="[1000,0]")
    await stage.registry.invoke(REF, "suspend")
    gate.set()
    await settle()
    assert stage.engine.heard == []
    await stage.registry.invoke(REF, "resume")
    await stage.ends_at(running, 1, 0, 0)


async def test_stop_halts_it(stage: Stage) -> None:
    running = await stage.begin(line="[3000,0]")
    await stage.run(1)
    await stage.registry.invoke(REF, "stop")
    with pytest.raises(Aborted):
        await running
    assert not stage.engine.moves


async def test_stop_halts_a_figure_that_turns_by_itself(stage: Stage) -> None:
    await stage.registry.invoke(REF, "stop")
    assert stage.engine.heard == [Halt()]


async def test_walk_that_the_engine_aborts_is_aborted(stage: Stage) -> None:
    running = await stage.begin(line="[3000,0]")
    stage.engine.break_off()
    with pytest.raises(Aborted, match="the body broke the motion off"):
        await running


async def test_a_hand_that_drives_comes_first(stage: Stage) -> None:
    running = await stage.begin(line="[3000,0]")
    stage.legs.drive(0, 1, 0)
    with pytest.raises(Aborted, match="an operator drives the body by hand"):
        await running
    await stage.run(1)
    assert (stage.engine.x, stage.engine.y) == pytest.approx((0, 0.5))


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"line": "[-1000000,0]"}, "line: the way has 2500 steps"),
        ({"curve": "[6000000,180]"}, "curve: the way leads beyond 10000 m"),
    ],
)
async def test_a_way_that_no_engine_can_be_told_is_refused_at_once(
    stage: Stage, values: dict[str, str], why: str
) -> None:
    with pytest.raises(BadParameter, match=why):
        await stage.set(**values)


async def test_a_way_that_leads_too_far_from_here_is_refused_when_it_starts(stage: Stage) -> None:
    stage.engine.x = 9_999.0
    stage.engine.tell_place()
    with pytest.raises(BadParameter, match="line: the way leads beyond 10000 m"):
        await (await stage.begin(line="[2000,0]"))
    assert stage.engine.heard == []
