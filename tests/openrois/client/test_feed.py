"""Bounded queues, and conditions: the small parts."""

import asyncio
import gc

import pytest

from openrois.client import Client, where
from openrois.client.feed import Feed
from openrois.engine.condition import parse_condition
from tests.support.grounds import Line

pytestmark = pytest.mark.extra(name="base")

PROPERTIES = frozenset({"component_ref", "component_type"})


async def test_the_oldest_makes_room_for_the_newest_and_is_counted() -> None:
    feed = Feed[int](buffer=2)
    for number in range(5):
        feed.offer(number)
    feed.end_feed()
    assert [number async for number in feed] == [3, 4]
    assert feed.dropped == 3


async def test_a_reader_waits_for_what_is_wanted() -> None:
    feed = Feed[int](wants=lambda number: number % 2 == 0)
    reading = asyncio.ensure_future(anext(feed))
    await asyncio.sleep(0)
    feed.offer(1)
    feed.offer(2)
    assert await reading == 2
    assert feed.dropped == 0


async def test_an_end_with_an_error_comes_after_what_waits_and_stays() -> None:
    feed = Feed[int]()
    feed.offer(1)
    feed.end_feed(ConnectionError("gone"))
    feed.end_feed()
    feed.offer(2)
    assert await anext(feed) == 1
    for _ in range(2):
        with pytest.raises(ConnectionError, match="gone"):
            await anext(feed)


async def test_several_readers_share_a_feed() -> None:
    feed = Feed[int]()
    reading = [asyncio.ensure_future(anext(feed)) for _ in range(3)]
    await asyncio.sleep(0)
    for number in range(3):
        feed.offer(number)
    assert sorted(await asyncio.gather(*reading)) == [0, 1, 2]


def test_a_buffer_holds_something() -> None:
    with pytest.raises(ValueError, match="buffer must be at least 1"):
        Feed[int](buffer=0)


async def test_a_feed_without_reader_is_dropped(line: Line) -> None:
    async with Client(dial=line.dial) as client:
        client.notices()
        feed = client.notifications()
        gc.collect()
        assert len(client._application.notices) == 0
        assert list(client._application.listeners) == [feed]


async def test_a_feed_ends_with_its_block(line: Line) -> None:
    async with Client(dial=line.dial) as client:
        async with client.notifications("example.news") as told:
            handlers = client._application.notifications
            handlers["example.news"]({"it": "rains"})
        handlers["example.news"]({"it": "snows"})
        assert [each.params async for each in told] == [{"it": "rains"}]
        async with client.notices() as notices:
            pass
        assert [each async for each in notices] == []


async def test_unknown_notifications_reach_their_readers(line: Line) -> None:
    async with Client(dial=line.dial) as client:
        told = client.notifications("example.news")
        handlers = client._application.notifications
        handlers["example.news"]({"it": "rains"})
        assert (await anext(told)).params == {"it": "rains"}
        assert len(handlers) == len(list(handlers)) == 5


@pytest.mark.parametrize("text", ["robot/navigation", "o'clock", "''", "' OR component_ref LIKE '%", ""])
def test_a_text_in_a_condition_is_a_text(text: str) -> None:
    condition = parse_condition(where(component_ref=text), PROPERTIES)
    assert len(condition.comparisons) == 1
    assert condition.value_of("component_ref") == text


def test_conditions_are_joined() -> None:
    written = where(component_type="urn:x", component_ref="a/b")
    assert written == "component_type = 'urn:x' AND component_ref = 'a/b'"
    assert where() == ""
