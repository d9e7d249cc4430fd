"""What waits for an event that takes little memory."""

import asyncio

from openrois.aio.lean_event import LeanEvent


async def test_an_event_wakes_all_that_wait_in_their_order() -> None:
    event, woken = LeanEvent(), []

    async def wait(name: str) -> None:
        await event.wait()
        woken.append(name)

    async with asyncio.TaskGroup() as tasks:
        for name in ("ann", "ben"):
            tasks.create_task(wait(name))
        await asyncio.sleep(0)
        assert (woken, event.is_set()) == ([], False)
        event.set()
        # Those that waited go on, though it is cleared before they run.
        event.clear()
    assert (woken, event.is_set()) == (["ann", "ben"], False)


async def test_of_an_event_that_is_set_nothing_waits_until_it_is_cleared() -> None:
    event = LeanEvent()
    event.set()
    await event.wait()
    event.set()
    event.clear()
    waiting = asyncio.ensure_future(event.wait())
    await asyncio.sleep(0)
    assert not waiting.done()
    event.set()
    await waiting


async def test_an_event_keeps_nothing_of_what_gave_up_waiting() -> None:
    event = LeanEvent()
    given_up, patient = asyncio.ensure_future(event.wait()), asyncio.ensure_future(event.wait())
    await asyncio.sleep(0)
    given_up.cancel()
    event.set()
    await asyncio.wait([given_up, patient])
    assert (given_up.cancelled(), patient.cancelled(), event._waiting) == (True, False, ())
