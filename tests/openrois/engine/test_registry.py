"""Components under one engine id. What every bus does is in `tests/contract`."""

import asyncio

import pytest

from openrois.contract import Event, Sink, SubscriptionLost
from openrois.engine.registry import MAX_QUERIES, LocalRegistry
from openrois.errors import BadParameter, OutOfResources, TimedOut, Unsupported
from tests.support.components import Bell, Lamp
from tests.support.deployment import Door
from tests.support.session import settle


@pytest.mark.parametrize("engine_id", ["", "a/b", "x" * 129])
def test_an_engine_id_that_cannot_lead_a_reference(engine_id: str) -> None:
    with pytest.raises(BadParameter):
        LocalRegistry(engine_id, [])


@pytest.mark.parametrize("names", [[""], ["a/b"], ["lamp", "lamp"]])
async def test_a_name_that_cannot_end_one(names: list[str]) -> None:
    with pytest.raises(BadParameter):
        LocalRegistry("robot", [Lamp(name) for name in names])


def test_a_class_is_no_component() -> None:
    with pytest.raises(TypeError, match=r"Lamp is a class: write Lamp\(\)"):
        LocalRegistry("robot", [Lamp])  # type: ignore[list-item]


async def test_the_profile_lists_components_in_the_order_they_were_given() -> None:
    directory = await LocalRegistry("robot", [Bell("b"), Lamp("a")]).discover()
    assert directory.profile.engine_ids() == ("robot",)
    assert directory.profile.component_ids == ("robot/b", "robot/a")
    assert list(directory.component_profiles) == ["robot/b", "robot/a"]


async def test_one_emission_is_one_event_for_every_subscriber() -> None:
    near, far = Bell("near"), Bell("far")
    registry = LocalRegistry("robot", [near, far], wall_clock=lambda: 0.0)
    heard: list[tuple[str, Event | SubscriptionLost]] = []

    def ear(name: str) -> Sink:
        return lambda item: heard.append((name, item))

    for name, ref in (("a", "robot/near"), ("b", "robot/near"), ("c", "robot/far")):
        await registry.subscribe(ref, "rang", ear(name))
    near.ring("ding")
    assert [name for name, _ in heard] == ["a", "b"]
    (event, again) = (item for _, item in heard)
    assert isinstance(event, Event)
    assert event is again
    assert event.event_id.startswith("robot/")
    assert (event.component_ref, event.event_type) == ("robot/near", "rang")
    assert event.expire == "1970-01-01T00:01:00.000000+00:00"
    near.ring("dong")
    assert len({item.event_id for _, item in heard if isinstance(item, Event)}) == 2


class Owl(Bell):
    """A bell that counts its subscribers."""

    def __init__(self) -> None:
        super().__init__("owl")
        self.told: list[tuple[str, int]] = []

    def subscribers_changed(self, event_type: str, number: int) -> None:
        self.told.append((event_type, number))


async def test_a_component_is_told_how_many_listen() -> None:
    owl, bell = Owl(), Bell("bell")
    registry = LocalRegistry("robot", [owl, bell])
    await registry.subscribe("robot/bell", "rang", lambda _item: None)
    first = await registry.subscribe("robot/owl", "rang", lambda _item: None)
    second = await registry.subscribe("robot/owl", "rang", lambda _item: None)
    with pytest.raises(Unsupported):
        await registry.subscribe("robot/owl", "sang", lambda _item: None)
    for subscribe_id in (first, first, "robot/unknown", second):
        await registry.unsubscribe(subscribe_id)
    assert owl.told == [("rang", 1), ("rang", 2), ("rang", 1), ("rang", 0)]


async def test_only_declared_events_can_be_listened_to() -> None:
    registry = LocalRegistry("robot", [Lamp()])
    with pytest.raises(Unsupported):
        await registry.subscribe("robot/lamp", "rang", lambda _item: None)


class TestComponentsThatHang:
    async def test_only_so_many_queries_at_a_time(self) -> None:
        door = Door("hung")
        door.may_answer.clear()
        registry = LocalRegistry("robot", [door, Door("other")])
        asking = [asyncio.ensure_future(registry.query("robot/hung", "view")) for _ in range(MAX_QUERIES)]
        await settle()
        with pytest.raises(OutOfResources):
            await registry.query("robot/hung", "view")
        assert len(await registry.query("robot/hung", "component_status")) == 1
        assert len(await registry.query("robot/other", "view")) == 1
        door.may_answer.set()
        await asyncio.gather(*asking)
        assert len(await registry.query("robot/hung", "view")) == 1

    async def test_a_query_ends(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("openrois.engine.registry.QUERY_TIMEOUT", 0.01)
        door = Door()
        door.may_answer.clear()
        registry = LocalRegistry("robot", [door])
        with pytest.raises(TimedOut, match="robot/door"):
            await registry.query("robot/door", "view")
