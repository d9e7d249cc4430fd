"""Events: iterators with a bounded buffer, typed payloads, and subscriptions that end without a reader."""

import asyncio
import gc
from datetime import datetime
from typing import Any

import pytest

from openrois.catalog.sensing import PersonDetected
from openrois.client import Client, ConnectionLost, Event, where
from openrois.client.components import Navigation, PersonDetection
from openrois.errors import BadParameter, Unsupported
from openrois.types.messages import Result
from tests.support.fleet import NOON
from tests.support.grounds import Ground, eventually

pytestmark = pytest.mark.extra(name="base")


@pytest.fixture
async def persons(client: Client) -> PersonDetection:
    return await client.find(PersonDetection)


async def test_events_are_payloads(ground: Ground, persons: PersonDetection) -> None:
    async with persons.person_detected() as detected:
        ground.robot.parts["PersonDetection"].tell("person_detected", number=3)
        assert await anext(detected) == PersonDetected(number=3, timestamp=NOON)


async def test_an_event_has_an_id_and_a_time(ground: Ground, client: Client, persons: PersonDetection) -> None:
    async with persons.person_detected() as detected:
        ground.robot.parts["PersonDetection"].tell("person_detected", number=3)
        event = await anext(detected.events())
        assert event.event_type == "person_detected"
        assert event.data.number == 3
        assert event.expire is not None
        assert event.expire.tzinfo is not None
        assert (await client.get_event_detail(event.event_id))[0].value == "3"


async def test_a_loop_subscribes_at_its_first_turn_and_leaving_it_ends_that(
    ground: Ground, client: Client, persons: PersonDetection
) -> None:
    part = ground.robot.parts["PersonDetection"]
    numbers = []

    async def listen() -> None:
        async for person in persons.person_detected():
            numbers.append(person.number)
            if len(numbers) == 2:
                break

    listening = asyncio.ensure_future(listen())
    await eventually(client, lambda: len(ground.engine._subscriptions) == 1)
    part.tell("person_detected", number=1)
    part.tell("person_detected", number=2)
    await listening
    gc.collect()
    await eventually(client, lambda: not ground.engine._subscriptions)


async def test_leaving_the_block_ends_the_subscription(ground: Ground, persons: PersonDetection) -> None:
    async with persons.person_detected() as detected:
        assert len(ground.engine._subscriptions) == 1
        assert detected.active
    assert not ground.engine._subscriptions
    assert [event async for event in detected] == []
    assert [event async for event in detected.events()] == []


async def test_what_a_reader_is_too_slow_for_is_counted(ground: Ground, client: Client) -> None:
    bell = client.component("toys/bell")
    async with bell.event("rang", buffer=2) as rang:
        for tune in "abcde":
            ground.bell.ring(tune)
        # An answer comes after what was told before it was asked.
        await client.search()
        assert rang.dropped == 3
        assert [await anext(rang), await anext(rang)] == [{"tune": "d"}, {"tune": "e"}]


async def test_two_subscriptions_to_the_same_event_hear_it_both(ground: Ground, client: Client) -> None:
    bell = client.component("toys/bell")
    async with bell.event("rang") as one, bell.event("rang") as other:
        ground.bell.ring("a scale")
        assert await anext(one) == await anext(other) == {"tune": "a scale"}


async def test_two_readers_of_one_subscription_share_it(ground: Ground, client: Client) -> None:
    rang = client.component("toys/bell").event("rang")
    reading = [asyncio.ensure_future(anext(rang)) for _ in range(2)]
    await eventually(client, lambda: len(ground.engine._subscriptions) > 0)
    for tune in ("a", "b"):
        ground.bell.ring(tune)
    assert sorted([each["tune"] for each in await asyncio.gather(*reading)]) == ["a", "b"]
    assert len(ground.engine._subscriptions) == 1
    await rang.close()


async def test_a_caller_cancelled_at_the_moment_of_subscribing_gets_no_events(
    ground: Ground, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    route = client._subscriptions._route

    def route_and_cancel(*arguments: Any) -> None:
        route(*arguments)
        asyncio.get_running_loop().call_soon(reading.cancel)

    monkeypatch.setattr(client._subscriptions, "_route", route_and_cancel)
    rang = client.component("toys/bell").event("rang")
    reading = asyncio.ensure_future(anext(rang))
    await asyncio.wait({reading})
    assert reading.cancelled()
    await eventually(client, lambda: not ground.engine._subscriptions)
    monkeypatch.undo()
    async with rang:
        ground.bell.ring("a scale")
        assert await anext(rang) == {"tune": "a scale"}


async def test_a_refused_subscription_raises_at_its_reader(client: Client) -> None:
    nothing = client.component(PersonDetection, "toys/nothing").person_detected()
    with pytest.raises(Unsupported, match=r"no component that (meets|satisfies) the condition has this"):
        await anext(nothing)
    with pytest.raises(BadParameter, match=r"(several|\d+) components"):
        async with client.subscribe("notify_stream_status"):
            pass


async def test_an_event_that_does_not_fit_is_passed_over_and_counted(ground: Ground, persons: PersonDetection) -> None:
    part = ground.robot.parts["PersonDetection"]
    async with persons.person_detected() as detected:
        part.emit("person_detected", (Result(name="number", data_type_ref="int", value="many"),))
        part.tell("person_detected", number=2)
        assert (await anext(detected)).number == 2
        assert detected.unreadable == 1


async def test_readers_stop_when_the_client_is_closed(ground: Ground) -> None:
    async with ground.client() as client:
        bell = client.component("toys/bell")
        rang = await bell.event("rang").__aenter__()
        ground.bell.ring("the last one")
        await client.search()
    if ground.extended:
        assert await anext(rang) == {"tune": "the last one"}
    else:
        # What it told would have to be asked for.
        assert rang.dropped == rang.unreadable == 0
    with pytest.raises(StopAsyncIteration):
        await anext(rang)
    with pytest.raises(ConnectionLost):
        await anext(bell.event("rang"))


async def test_a_subscription_says_what_it_is(client: Client) -> None:
    navigation = client.component(Navigation, "robot/navigation")
    assert repr(navigation.reached_target()) == (
        f"<Subscription to reached_target where {where(component_ref='robot/navigation')}>"
    )
    with pytest.raises(ValueError, match="buffer must be at least 1"):
        navigation.reached_target(buffer=0)


def test_an_event_is_a_value() -> None:
    event = Event("gateway/1", "rang", datetime(2026, 6, 1), {"tune": "a scale"})
    assert event == Event("gateway/1", "rang", datetime(2026, 6, 1), {"tune": "a scale"})
