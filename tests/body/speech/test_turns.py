"""The order of speeches, on a clock turned by hand."""

import asyncio

import pytest
from openrois_body.sound.mixer import SoundBusy
from openrois_body.speech.turns import EARLY, LONGEST_LINE, Line

from tests.support.streaming import VirtualClock, settle


async def test_each_comes_shortly_before_the_end_of_the_one_before_in_the_order_of_joining() -> None:
    clock = VirtualClock()
    line = Line(clock)
    first, second, third = (line.join() for _ in range(3))
    assert await first.comes()
    waiting = [asyncio.ensure_future(turn.comes()) for turn in (second, third)]
    await clock.advance(5)
    first.set_end(clock.now() + 1)
    await clock.advance(1 - EARLY - 0.01)
    assert [each.done() for each in waiting] == [False, False]
    await clock.advance(0.02)
    assert [each.done() for each in waiting] == [True, False]
    second.set_end(clock.now())
    await settle()
    assert [await each for each in waiting] == [True, True]


async def test_one_that_is_over_before_its_end_lets_the_next_one_come_at_once() -> None:
    clock = VirtualClock()
    line = Line(clock)
    first, second = line.join(), line.join()
    first.set_end(clock.now() + 100)
    waiting = asyncio.ensure_future(second.comes())
    await settle()
    assert not waiting.done()
    first.pass_on()
    first.pass_on()
    assert await waiting


async def test_one_that_gives_up_lets_the_next_one_come() -> None:
    line = Line(VirtualClock())
    first, second, third = (line.join() for _ in range(3))
    waiting = asyncio.ensure_future(second.comes())
    await settle()
    second.give_up()
    assert not await waiting
    second.pass_on()
    first.pass_on()
    assert await third.comes()


async def test_the_line_is_bounded() -> None:
    line = Line(VirtualClock())
    turns = [line.join() for _ in range(LONGEST_LINE)]
    with pytest.raises(SoundBusy, match=f"{LONGEST_LINE} speeches wait already"):
        line.join()
    turns[0].pass_on()
    assert line.join() is not None
