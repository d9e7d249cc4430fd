"""The map of the scene, as an application reads it."""

import json
from collections.abc import AsyncIterator

import pytest
from openrois_body.components.surroundings import Surroundings
from openrois_body.messages import Floor, Place, Thing, Things
from openrois_body.motion.world import World

from openrois.contract import Event, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed
from openrois.testing import ComponentContract
from openrois.types.codes import ComponentStatus
from tests.support.streaming import VirtualClock, settle

REF = "avatar/surroundings"


class TestSurroundings(ComponentContract):
    async def component(self) -> Surroundings:
        return Surroundings(World("avatar"), VirtualClock(), lambda: ComponentStatus.READY)


class Stage:
    def __init__(self) -> None:
        self.status = ComponentStatus.READY
        self.world = World("avatar")
        self.clock = VirtualClock()
        self.component = Surroundings(self.world, self.clock, lambda: self.status)
        self.registry = LocalRegistry("avatar", [self.component])
        self.heard: list[tuple[str, list[str]]] = []

    def hear(self, item: Event | SubscriptionLost) -> None:
        assert isinstance(item, Event)
        self.heard.append((item.event_type, [result.value for result in item.results]))

    async def ask(self, query: str) -> dict[str, object]:
        return {result.name: json.loads(result.value) for result in await self.registry.query(REF, query)}


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    await stage.component.bring_up()
    yield stage
    await stage.component.take_down()


async def test_the_floor_is_told_by_its_corners(stage: Stage) -> None:
    assert await stage.ask("floor") == {"outline": [], "obstacles": []}
    stage.world.handle_event(Floor(((0, 0), (4, 0), (4, 3.25)), (((1, 1), (2, 1), (1.5, 2)),)))
    assert await stage.ask("floor") == {
        "outline": ["0.000,0.000", "4.000,0.000", "4.000,3.250"],
        "obstacles": [["1.000,1.000", "2.000,1.000", "1.500,2.000"]],
    }


async def test_things_are_told_side_by_side(stage: Stage) -> None:
    stage.world.handle_event(Things((Thing("a", "person", 1, 2, 0.5, "Anna"), Thing("t", "object", 0, 0))))
    assert await stage.ask("things") == {
        "thing_ref": [
            "urn:x-rois:def:person:OpenRoIS::avatar/scene/a",
            "urn:x-rois:def:object:OpenRoIS::avatar/scene/t",
        ],
        "kind": ["person", "object"],
        "name": ["Anna", ""],
        "position_data": ["1.000,2.000,0.5000", "0.000,0.000,0.0000"],
    }


async def test_changes_are_told(stage: Stage) -> None:
    for event in ("figure_moved", "floor_changed", "things_changed"):
        await stage.registry.subscribe(REF, event, stage.hear)
    stage.world.handle_event(Place(1, -2, 0.25))
    stage.world.handle_event(Floor(((0, 0), (4, 0), (4, 3))))
    stage.world.handle_event(Things((Thing("t", "object", 0, 2),)))
    await settle()
    assert sorted(stage.heard) == [
        ("figure_moved", ["1.000,-2.000,0.2500"]),
        ("floor_changed", []),
        ("things_changed", []),
    ]
    stage.heard.clear()
    stage.world.clear()
    await stage.clock.advance(0.1)
    assert sorted(stage.heard) == [("floor_changed", []), ("things_changed", [])]


async def test_a_flood_of_changes_is_told_twenty_times_a_second_and_ends_with_the_last(stage: Stage) -> None:
    for event in ("figure_moved", "things_changed"):
        await stage.registry.subscribe(REF, event, stage.hear)
    for step in range(1, 1001):
        stage.world.handle_event(Place(step / 10, 0, 0))
        stage.world.handle_event(Things((Thing("t", "object", step / 10, 2),)))
        if step % 10 == 0:
            await stage.clock.advance(0.0078125)
    await stage.clock.advance(1)
    told = [name for name, _ in stage.heard]
    assert 10 <= told.count("figure_moved") <= 18  # in 0.8 s
    assert 5 <= told.count("things_changed") <= 10
    assert [values for name, values in stage.heard if name == "figure_moved"][-1] == ["100.000,0.000,0.0000"]


async def test_where_the_figure_was_is_not_told_when_the_engine_is_gone(stage: Stage) -> None:
    await stage.registry.subscribe(REF, "figure_moved", stage.hear)
    stage.world.handle_event(Place(1, -2, 0.25))
    stage.world.clear()
    await settle()
    assert stage.heard == []


async def test_without_an_engine_there_is_no_map(stage: Stage) -> None:
    stage.status = ComponentStatus.ERROR
    with pytest.raises(ComponentFailed):
        await stage.registry.query(REF, "floor")
