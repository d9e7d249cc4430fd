"""The event log: numbered, bounded, and waited for."""

import asyncio
from datetime import UTC, datetime

import pytest
from openrois_agents.tools.event_log import MAX_EVENTS, EventLog

pytestmark = pytest.mark.extra(name="mcp")


def test_it_keeps_the_newest_and_their_numbers() -> None:
    log = EventLog(lambda: datetime(2026, 1, 2, tzinfo=UTC))
    for number in range(MAX_EVENTS + 10):
        log.add("heard", "robot/hearing", {"text": str(number)})
    kept = log.after(0)
    assert (len(kept), kept[0].number, log.last) == (MAX_EVENTS, 11, MAX_EVENTS + 10)
    assert kept[-1].as_json() == {
        "number": 266,
        "at": "2026-01-02T00:00:00.000+00:00",
        "event": "heard",
        "source": "robot/hearing",
        "data": {"text": "265"},
    }


async def test_what_is_waited_for_is_told_at_once_and_nothing_else() -> None:
    log = EventLog()
    waiting = asyncio.ensure_future(log.wait(0, ("heard",), 30))
    await asyncio.sleep(0)
    log.add("seen", "robot/sight", {})
    await asyncio.sleep(0)
    assert not waiting.done()
    log.add("heard", "robot/hearing", {})
    assert [each.name for each in await waiting] == ["heard"]
    assert [each.number for each in await log.wait(0, (), 30)] == [1, 2]


async def test_when_nothing_comes_the_wait_ends() -> None:
    assert await EventLog().wait(0, (), 0) == []
