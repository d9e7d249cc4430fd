"""The order of speeches whose ends are known late."""

import asyncio

import pytest
from openrois_body.sound.mixer import SoundBusy
from openrois_body.speech.turns import LONGEST_LINE, Line

from tests.support.streaming import settle


async def test_each_comes_when_the_end_of_the_one_before_is_known_in_the_order_of_joining() -> None:
    line = Line()
    first, second, third = (line.join() for _ in range(3))
    assert await first.comes()
    waiting = [asyncio.ensure_future(turn.comes()) for turn in (second, third)]
    await settle()
    assert not any(each.done() for each in waiting)
    third.pass_on()
    first.pass_on()
    first.pass_on()
    assert [await each for each in waiting] == [True, False]
    assert await asyncio.wait_for(second.comes(), 1)


async def test_one_that_gives_up_lets_the_next_one_come() -> None:
    line = Line()
    first, second, third = (line.join() for _ in range(3))
    second.settle(False)
    assert not await second.comes()
    second.pass_on()
    first.pass_on()
    assert await third.comes()


async def test_a_waiter_that_is_cancelled_leaves_its_place_to_be_given_up() -> None:
    line = Line()
    first, second = line.join(), line.join()
    waiting = asyncio.ensure_future(second.comes())
    await settle()
    waiting.cancel()
    await asyncio.wait({waiting})
    second.pass_on()
    first.pass_on()
    assert await line.join().comes()


async def test_the_line_is_bounded() -> None:
    line = Line()
    turns = [line.join() for _ in range(LONGEST_LINE)]
    with pytest.raises(SoundBusy, match=f"{LONGEST_LINE} speeches wait already"):
        line.join()
    turns[0].pass_on()
    assert line.join() is not None
