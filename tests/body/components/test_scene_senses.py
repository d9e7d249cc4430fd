"""People and sounds of the scene, as the engine reports them."""

import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest
from openrois_body.components.scene_senses import scene_senses
from openrois_body.messages import Thing, Things
from openrois_body.motion.world import World

from openrois.contract import Event, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.types.codes import ComponentStatus
from openrois.types.messages import Argument
from tests.support.streaming import VirtualClock, settle

ANNA, BOB = Thing("a", "person", 1, 2, 0.5), Thing("b", "person", 0, 3)
BELL, TABLE = Thing("bell", "sound", -1, 0), Thing("t", "object", 4, 4)
LOCALIZATION = "scene_person_localizer"
PAUSE = 0.0625
"""Longer than a sense is silent for, and without a rounding error."""


class Stage:
    def __init__(self) -> None:
        self.clock = VirtualClock(wall=1_700_000_000)
        self.world = World("avatar")
        self.status = ComponentStatus.READY
        self.senses = scene_senses(self.world, self.clock, lambda: self.status)
        self.registry = LocalRegistry("avatar", self.senses)
        self.heard: list[dict[str, str]] = []

    async def show(self, *things: Thing) -> None:
        """Have the engine report these things, a while after it reported others."""
        await self.clock.advance(PAUSE)
        self.world.handle_event(Things(things))
        await settle()

    async def listen(self, sense: str, event: str) -> str:
        subscription = await self.registry.subscribe(f"avatar/{sense}", event, self._hear)
        await settle()
        return subscription

    def _hear(self, item: Event | SubscriptionLost) -> None:
        assert isinstance(item, Event)
        self.heard.append({result.name: result.value for result in item.results})

    def told(self, name: str) -> list[str]:
        told = [event[name] for event in self.heard]
        self.heard.clear()
        return told

    async def set(self, sense: str, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="int", value=value) for name, value in values.items())
        await self.registry.invoke(f"avatar/{sense}", "set_parameter", arguments)


@pytest.fixture
async def stage() -> AsyncIterator[Stage]:
    stage = Stage()
    async with AsyncExitStack() as stack:
        for sense in stage.senses:
            await sense.bring_up()
            stack.push_async_callback(sense.take_down)
        yield stage


async def test_another_number_of_persons_is_told(stage: Stage) -> None:
    await stage.listen("scene_person_detecter", "person_detected")
    assert stage.heard == []
    await stage.show(ANNA, BELL, TABLE)
    await stage.show(Thing("a", "person", 2, 2), BELL)
    await stage.show(ANNA, BOB)
    await stage.show()
    assert [event["timestamp"] for event in stage.heard] == [
        f"2023-11-14T22:13:20.{part}+00:00" for part in ("062500", "187500", "250000")
    ]
    assert stage.told("number") == ["1", "2", "0"]


async def test_persons_are_told_with_ref_and_place(stage: Stage) -> None:
    await stage.show(ANNA, BELL)
    await stage.listen(LOCALIZATION, "person_localized")
    assert stage.heard == [
        {
            "person_ref": '["urn:x-rois:def:person:OpenRoIS::avatar/scene/a"]',
            "timestamp": "2023-11-14T22:13:20.062500+00:00",
            "position_data": '["1.000,2.000,0.5000"]',
        }
    ]


async def test_sounds_are_told_with_ref_and_place(stage: Stage) -> None:
    await stage.listen("scene_sound_localizer", "sound_localized")
    await stage.show(ANNA, BELL)
    assert [json.loads(event["sound_ref"]) for event in stage.heard] == [
        ["urn:x-rois:def:sound:OpenRoIS::avatar/scene/bell"]
    ]
    assert stage.told("position_data") == ['["-1.000,0.000,0.0000"]']


async def test_small_movements_add_up_to_the_threshold(stage: Stage) -> None:
    await stage.set(LOCALIZATION, detection_threshold="100")
    await stage.listen(LOCALIZATION, "person_localized")
    for x in (0.0, 0.06, 0.12, 0.18):
        await stage.show(Thing("a", "person", x, 0))
    assert stage.told("position_data") == ['["0.000,0.000,0.0000"]', '["0.120,0.000,0.0000"]']


async def test_early_change_is_announced_later_with_its_present_value(stage: Stage) -> None:
    await stage.set(LOCALIZATION, minimum_interval="1000")
    await stage.listen(LOCALIZATION, "person_localized")
    for x in (0.0, 0.5, 1.0):
        await stage.show(Thing("a", "person", x, 0))
        await stage.clock.advance(0.1)
    assert stage.told("position_data") == ['["0.000,0.000,0.0000"]']
    await stage.clock.advance(0.8)
    assert stage.told("position_data") == ['["1.000,0.000,0.0000"]']
    await stage.clock.advance(5)
    assert stage.heard == []


async def test_later_subscriber_gets_the_present_scene(stage: Stage) -> None:
    await stage.show(ANNA)
    for event, sense in (("person_detected", "scene_person_detecter"), ("person_localized", LOCALIZATION)):
        for _ in range(2):
            subscription = await stage.listen(sense, event)
            assert len(stage.told("timestamp")) == 1
            await stage.registry.unsubscribe(subscription)
            await stage.show(ANNA, BOB)
            await stage.show(ANNA)
            assert stage.heard == []


async def test_person_that_appears_after_the_last_one_left_is_announced_before_the_interval_ends(stage: Stage) -> None:
    await stage.set(LOCALIZATION, minimum_interval="60000")
    await stage.show(ANNA)
    for _ in range(2):
        subscription = await stage.listen(LOCALIZATION, "person_localized")
        await stage.clock.advance(1)
        assert len(stage.told("position_data")) == 1
        await stage.registry.unsubscribe(subscription)


@pytest.mark.parametrize("interval", [100, 300, 700])
async def test_early_change_is_announced_despite_rounding_of_the_interval(stage: Stage, interval: int) -> None:
    await stage.set(LOCALIZATION, minimum_interval=str(interval))
    await stage.listen(LOCALIZATION, "person_localized")
    for x in range(20):
        await stage.show(Thing("a", "person", x, 0))
        stage.world.handle_event(Things((Thing("a", "person", x, 1),)))
        await stage.clock.advance(2 * interval / 1000)
        assert stage.told("position_data")[-1] == f'["{x}.000,1.000,0.0000"]'


async def test_stopped_it_tells_nothing(stage: Stage) -> None:
    await stage.listen(LOCALIZATION, "person_localized")
    await stage.registry.invoke(f"avatar/{LOCALIZATION}", "stop")
    await stage.show(ANNA)
    assert stage.heard == []
    await stage.registry.invoke(f"avatar/{LOCALIZATION}", "start")
    await settle()
    assert len(stage.heard) == 1


async def test_departure_during_inactivity_is_announced(stage: Stage) -> None:
    await stage.listen("scene_person_detecter", "person_detected")
    await stage.show(ANNA, BOB)
    await stage.registry.invoke("avatar/scene_person_detecter", "suspend")
    await stage.show()
    await stage.registry.invoke("avatar/scene_person_detecter", "resume")
    await stage.clock.advance(PAUSE)
    assert stage.told("number") == ["2", "0"]


async def test_with_the_engine_the_scene_is_gone(stage: Stage) -> None:
    await stage.listen("scene_person_detecter", "person_detected")
    await stage.show(ANNA)
    stage.world.clear()
    await stage.clock.advance(PAUSE)
    assert stage.told("number") == ["1", "0"]
    stage.status = ComponentStatus.ERROR
    for sense in stage.senses:
        assert sense.status is ComponentStatus.ERROR


async def test_a_flood_of_changes_is_looked_at_twenty_times_a_second(stage: Stage) -> None:
    await stage.listen(LOCALIZATION, "person_localized")
    for step in range(1, 1001):
        stage.world.handle_event(Things((Thing("a", "person", step / 10, 0),)))
        if step % 10 == 0:
            await stage.clock.advance(0.0078125)
    await stage.clock.advance(1)
    places = stage.told("position_data")
    assert 10 <= len(places) <= 18  # in 0.8 s
    assert places[-1] == '["100.000,0.000,0.0000"]'


async def test_an_interval_that_is_taken_back_does_not_last(stage: Stage) -> None:
    await stage.listen(LOCALIZATION, "person_localized")
    await stage.set(LOCALIZATION, minimum_interval="4611686018427387904")
    await stage.show(ANNA)
    await stage.show(BOB)
    assert len(stage.told("position_data")) == 1
    await stage.set(LOCALIZATION, minimum_interval="0")
    await stage.clock.advance(0.5)
    assert stage.told("position_data") == ['["0.000,3.000,0.0000"]']
