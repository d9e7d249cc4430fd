"""The starts of a component: one at a time, and a stop ends those before it."""

import asyncio

import pytest

from openrois.component.start_slot import StartSlot
from openrois.errors import Aborted
from tests.support.session import settle


class Work:
    """Something that goes on until it is cancelled, and then until it is let go."""

    def __init__(self) -> None:
        self.begun = 0
        self.let_go = asyncio.Event()

    async def __call__(self) -> int:
        self.begun += 1
        try:
            return await asyncio.Event().wait()
        finally:
            await self.let_go.wait()


async def test_the_next_start_begins_when_the_one_before_has_ended() -> None:
    starts, work = StartSlot[int](), Work()
    first = asyncio.ensure_future(starts.run("arm", work))
    await settle()
    second = asyncio.ensure_future(starts.run("arm", work))
    await settle()
    assert work.begun == 1
    work.let_go.set()
    with pytest.raises(Aborted, match="arm was stopped"):
        await first
    await settle()
    assert work.begun == 2
    await starts.end_running()
    with pytest.raises(Aborted):
        await second


async def test_a_stop_ends_what_came_before_it_begun_or_not_and_nothing_else() -> None:
    starts, work = StartSlot[int](), Work()
    before = [asyncio.ensure_future(starts.run("arm", work)) for _ in range(2)]
    await settle()
    came = starts.came
    after = asyncio.ensure_future(starts.run("arm", work))
    stopping = asyncio.ensure_future(starts.stop(came))
    await settle()
    assert work.begun == 1
    work.let_go.set()
    await stopping
    for each in before:
        with pytest.raises(Aborted):
            await each
    await settle()
    assert (work.begun, after.done()) == (2, False)
    await starts.stop(starts.came)
    with pytest.raises(Aborted):
        await after
