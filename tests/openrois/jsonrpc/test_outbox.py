"""Order and budgets of what waits to be sent."""

import asyncio
import logging

import pytest

from openrois.jsonrpc.outbox import Outbox, OutboxOverflow


async def taken(outbox: Outbox) -> list[str]:
    return [await outbox.get() for _ in range(len(outbox))]


async def test_what_is_put_is_taken_in_order() -> None:
    outbox = Outbox()
    for text, droppable in (("a", False), ("b", True), ("c", False)):
        outbox.put(text, droppable=droppable)
    assert await taken(outbox) == ["a", "b", "c"]


async def test_a_taker_waits_for_the_next() -> None:
    outbox = Outbox()
    taking = asyncio.ensure_future(outbox.get())
    await asyncio.sleep(0)
    assert not taking.done()
    outbox.put("a")
    assert await taking == "a"


async def test_too_many_events_drop_the_oldest_event_and_nothing_else() -> None:
    outbox = Outbox(control_limit=4, event_limit=2)
    for text in ("reply 1", "event 1", "reply 2", "event 2", "event 3", "event 4", "reply 3"):
        outbox.put(text, droppable=text.startswith("event"))
    assert outbox.dropped == 2
    assert await taken(outbox) == ["reply 1", "reply 2", "event 3", "event 4", "reply 3"]


async def test_where_events_were_dropped_a_notice_may_stand() -> None:
    outbox = Outbox(event_limit=2)
    outbox.gap = lambda dropped: f"{dropped} missing"
    for text in ("event 1", "reply 1", "event 2", "event 3", "event 4", "reply 2"):
        outbox.put(text, droppable=text.startswith("event"))
    assert [await outbox.get() for _ in range(5)] == ["reply 1", "2 missing", "event 3", "event 4", "reply 2"]
    for number in range(5, 8):
        outbox.put(f"event {number}", droppable=True)
    assert [await outbox.get() for _ in range(3)] == ["1 missing", "event 6", "event 7"]


async def test_what_went_missing_without_a_notice_is_not_told_later() -> None:
    outbox = Outbox(event_limit=1)
    for number in range(3):
        outbox.put(str(number), droppable=True)
    assert await outbox.get() == "2"
    outbox.gap = lambda dropped: f"{dropped} missing"
    outbox.put("3", droppable=True)
    assert await outbox.get() == "3"


async def test_one_control_message_too_many_overflows_and_is_not_kept() -> None:
    outbox = Outbox(control_limit=2, event_limit=5)
    outbox.put("event", droppable=True)
    outbox.put("1")
    outbox.put("2")
    with pytest.raises(OutboxOverflow):
        outbox.put("3")
    assert await taken(outbox) == ["event", "1", "2"]


async def test_room_comes_back_as_messages_are_taken() -> None:
    outbox = Outbox(control_limit=1, event_limit=1)
    for _ in range(3):
        outbox.put("control")
        outbox.put("event", droppable=True)
        assert await taken(outbox) == ["control", "event"]
    assert outbox.dropped == 0


async def test_callers_get_room_in_the_order_of_their_requests() -> None:
    outbox, asked = Outbox(control_limit=2), list[str]()

    async def ask(name: str) -> None:
        await outbox.room()
        asked.append(name)
        outbox.put(name)

    outbox.put("a")
    tasks = [asyncio.ensure_future(ask(name)) for name in ("first", "second")]
    await asyncio.sleep(0)
    assert asked == []
    assert await outbox.get() == "a"
    # There is room, and the call that waits for it has not noticed.
    tasks.append(asyncio.ensure_future(ask("third")))
    async with asyncio.timeout(1):
        assert [await outbox.get() for _ in range(3)] == ["first", "second", "third"]
    await asyncio.gather(*tasks)


async def test_drops_are_logged_ever_more_seldom(caplog: pytest.LogCaptureFixture) -> None:
    outbox = Outbox(event_limit=1)
    with caplog.at_level(logging.WARNING):
        for _ in range(1 + 100):
            outbox.put("event", droppable=True)
    assert outbox.dropped == 100
    assert len(caplog.records) == 7


async def test_drained_waits_until_the_taker_asks_for_more() -> None:
    outbox = Outbox()
    async with asyncio.timeout(1):
        await outbox.drained()
    outbox.put("a")
    draining = asyncio.ensure_future(outbox.drained())
    await outbox.get()
    await asyncio.sleep(0)
    assert not draining.done()
    taking = asyncio.ensure_future(outbox.get())
    async with asyncio.timeout(1):
        await draining
    taking.cancel()


async def test_text_is_bounded_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois.jsonrpc.outbox.CONTROL_TEXT", 10)
    monkeypatch.setattr("openrois.jsonrpc.outbox.EVENT_TEXT", 10)
    outbox = Outbox()
    outbox.put("a" * 11)
    with pytest.raises(OutboxOverflow):
        outbox.put("b")
    for text in ("c" * 5, "d" * 5, "e" * 6, "f" * 11):
        outbox.put(text, droppable=True)
    assert outbox.dropped == 3
    assert await taken(outbox) == ["a" * 11, "f" * 11]
    outbox.put("b" * 10)
    assert await taken(outbox) == ["b" * 10]


async def test_a_request_waits_while_it_is_half_full() -> None:
    outbox = Outbox(control_limit=4)
    for text in ("a", "b", "c"):
        async with asyncio.timeout(1):
            await (outbox.room() if text != "c" else asyncio.sleep(0))
        outbox.put(text)
    waiting = asyncio.ensure_future(outbox.room())
    for text in ("a", "b"):
        await asyncio.sleep(0)
        assert not waiting.done()
        assert await outbox.get() == text
    async with asyncio.timeout(1):
        await waiting


async def test_a_closed_outbox_releases_every_caller() -> None:
    outbox = Outbox(control_limit=2)
    outbox.put("a")
    waiting = asyncio.ensure_future(outbox.room())
    await asyncio.sleep(0)
    outbox.close()
    async with asyncio.timeout(1):
        await waiting
        await outbox.room()


async def test_some_are_as_many_as_fit_and_one_at_least() -> None:
    outbox = Outbox()
    taking = asyncio.ensure_future(outbox.get_some(4))
    await asyncio.sleep(0)
    for text in ("too long", "a", "b" * 2, "c", "d"):
        outbox.put(text)
    assert await taking == ["too long"]
    assert await outbox.get_some(4) == ["a", "bb", "c"]
    assert await outbox.get_some(4) == ["d"]
