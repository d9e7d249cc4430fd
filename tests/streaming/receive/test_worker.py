import asyncio
import threading

import pytest
from openrois_streaming.receive.worker import Handover


async def test_items_pass_in_their_order() -> None:
    handover = Handover[int](10)

    def fill() -> None:
        for number in range(5):
            handover.put(number)

    thread = threading.Thread(target=fill)
    thread.start()
    assert [await anext(handover) for _ in range(5)] == list(range(5))
    thread.join()


async def test_the_oldest_is_lost() -> None:
    handover = Handover[int](2)
    for number in range(5):
        handover.put(number)
    assert [await anext(handover), await anext(handover)] == [3, 4]
    assert handover.lost == 3


async def test_after_the_end_nothing_comes() -> None:
    handover = Handover[int](2)
    handover.put(1)
    handover.end_input()
    handover.put(2)
    handover.end_input(ValueError("too late"))
    assert [each async for each in handover] == [1]
    assert [each async for each in handover] == []


async def test_a_failure_comes_after_what_waits() -> None:
    handover = Handover[int](2)
    handover.put(1)
    handover.end_input(ValueError("broken"))
    assert await anext(handover) == 1
    with pytest.raises(ValueError, match="broken"):
        await anext(handover)


async def test_a_reader_that_waits_is_woken() -> None:
    handover = Handover[int](2)
    waiting = asyncio.ensure_future(anext(handover))
    await asyncio.sleep(0)
    handover.put(1)
    assert await waiting == 1
    waiting = asyncio.ensure_future(anext(handover))
    await asyncio.sleep(0)
    handover.end_input()
    with pytest.raises(StopAsyncIteration):
        await waiting


def test_a_loop_that_is_closed_is_no_failure() -> None:
    async def made() -> Handover[int]:
        return Handover[int](1)

    handover = asyncio.run(made())
    handover.put(1)
    handover.end_input()
