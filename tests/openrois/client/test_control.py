"""Control: a lost connection is resumed, components change hands, and everything stops."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest

from openrois.client import (
    BindingLost,
    Client,
    Connected,
    ConnectionLost,
    ControlChanged,
    ControlDeclined,
    ControlRequested,
    ControlWithdrawn,
)
from openrois.errors import Aborted, ComponentFailed, OutOfResources, Unsupported
from openrois.types.leases import LeaseState
from tests.support import grounds
from tests.support.grounds import Clock, Line

LAMP = "toys/lamp"


@pytest.fixture
async def line() -> AsyncIterator[Line]:
    async with grounds.line(grace=10) as running:
        yield running


@pytest.fixture
async def ann(line: Line, clock: Clock) -> AsyncIterator[Client]:
    async with Client(dial=line.dial, reconnect=clock.reconnect()) as connected:
        yield connected


@pytest.fixture
async def bob(line: Line) -> AsyncIterator[Client]:
    async with Client(dial=line.dial) as connected:
        yield connected


async def heard(notices: AsyncIterator[Any]) -> Any:
    async with asyncio.timeout(60):
        return await anext(notices)


class TestResuming:
    async def test_what_ran_is_told_of(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        line.cut()
        await clock.pass_time()
        await heard(notices)
        assert not running.done
        line.lamp.may_end.set()
        await running

    async def test_what_ended_meanwhile_is_told_of(self, line: Line, clock: Clock, ann: Client) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        line.cut()
        await clock.asleep()
        line.lamp.may_end.set()
        await clock.pass_time()
        await running

    async def test_nobody_else_has_it_meanwhile(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        await ann.bind(LAMP)
        line.cut()
        await clock.asleep()
        async with Client(dial=line.dial) as eve:
            with pytest.raises(OutOfResources):
                await eve.bind(LAMP)
            assert (await eve.control.status(LAMP)).state is LeaseState.ABSENT
            await clock.pass_time()
            await heard(notices)
            assert (await eve.control.status(LAMP)).state is LeaseState.HELD
            await ann.component(LAMP).command("switch", times=1)

    async def test_what_was_given_back_meanwhile_is_free(self, line: Line, clock: Clock, ann: Client) -> None:
        notices = ann.notices(Connected)
        async with ann.bound(LAMP):
            line.cut()
            await clock.asleep()
        await clock.pass_time()
        await heard(notices)
        async with Client(dial=line.dial) as eve:
            await eve.bind(LAMP)

    async def test_what_the_gateway_does_not_know_is_lost(self, line: Line, clock: Clock, ann: Client) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        ann._application._resumption._token = "another"
        line.cut()
        await clock.pass_time()
        with pytest.raises(ConnectionLost):
            await running

    async def test_who_does_not_come_back_learns_it_in_time(self, line: Line, clock: Clock, ann: Client) -> None:
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        ann._application._resumption._grace = 0.01
        line.cut()
        with pytest.raises(ConnectionLost, match="1006"):
            await running
        await clock.pass_time()

    async def test_a_connection_that_the_gateway_takes_for_alive(self, line: Line, clock: Clock) -> None:
        """Only our end is gone at first: the gateway learns of it later."""
        notices: Any
        async with Client(dial=line.dial, reconnect=clock.reconnect()) as ann:
            notices = ann.notices(Connected)
            await ann.bind(LAMP)
            running = await ann.component(LAMP).command("start").execute()
            await line.lamp.glowing.wait()
            (far,) = line._ends
            near = far._other
            far._other, near._other = near, near
            near.abort()
            await clock.pass_time()
            await heard(notices)
            far._other = far
            assert not running.done
            far.abort()
            await clock.asleep()
            while not running.done:
                await clock.pass_time()
                line.lamp.may_end.set()
                await ann.search()
            await running


class TestHandover:
    async def test_granted(self, line: Line, ann: Client, bob: Client) -> None:
        told, lost = ann.notices(ControlRequested), ann.notices(BindingLost)
        await ann.bind(LAMP)
        running = await ann.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        asking = asyncio.ensure_future(bob.control.request(LAMP))
        asked = await heard(told)
        assert (asked.component_ref, asked.subject, 0 < asked.within <= 30) == (LAMP, "local", True)
        await ann.control.grant(asked.request_id)
        await asking
        with pytest.raises(Aborted, match="handed it over"):
            await running
        assert (await heard(lost)).component_ref == LAMP
        await bob.component(LAMP).command("switch", times=1)
        with pytest.raises(OutOfResources):
            await ann.component(LAMP).command("switch", times=1)

    async def test_declined(self, ann: Client, bob: Client) -> None:
        told, declined, withdrawn = (
            ann.notices(ControlRequested),
            bob.notices(ControlDeclined),
            ann.notices(ControlWithdrawn),
        )
        await ann.bind(LAMP)
        asking = asyncio.ensure_future(bob.control.request(LAMP))
        asked = await heard(told)
        await ann.control.decline(asked.request_id)
        with pytest.raises(OutOfResources, match="its holder keeps it"):
            await asking
        assert (await heard(declined)).request_id == asked.request_id
        assert (await heard(withdrawn)).request_id == asked.request_id

    async def test_waiting_in_line(self, ann: Client, bob: Client) -> None:
        told, changed = ann.notices(ControlRequested), ann.notices(ControlChanged)
        await ann.bind(LAMP)
        asking = asyncio.ensure_future(bob.control.request(LAMP, wait=True))
        await ann.control.decline((await heard(told)).request_id)
        assert (await heard(changed)).waiting == 1
        await ann.release(LAMP)
        await asking
        assert (await ann.control.status(LAMP)).state is LeaseState.HELD

    async def test_a_free_one_and_one_that_is_no_actuation(self, ann: Client) -> None:
        await ann.control.request(LAMP)
        await ann.component(LAMP).command("switch", times=1)
        with pytest.raises(Unsupported):
            await ann.control.request("toys/bell")

    async def test_taken(self, ann: Client, bob: Client) -> None:
        lost = ann.notices(BindingLost)
        await ann.bind(LAMP)
        await bob.control.take(LAMP)
        assert "an administrator has taken it" in str((await heard(lost)).error)
        await bob.component(LAMP).command("switch", times=1)

    async def test_whoever_goes_does_not_wait(self, line: Line, ann: Client, bob: Client) -> None:
        await bob.bind(LAMP)
        told = bob.notices(ControlRequested)
        asking = asyncio.ensure_future(ann.control.request(LAMP))
        await heard(told)
        line.cut()
        with pytest.raises(ConnectionLost):
            await asking


async def test_stop(line: Line, ann: Client, bob: Client) -> None:
    await ann.bind(LAMP)
    running = await ann.component(LAMP).command("start").execute()
    await line.lamp.glowing.wait()
    assert LAMP in await bob.control.stop_all("toys")
    with pytest.raises(Aborted):
        await running
    assert LAMP in await ann.control.stop_all(component_ref=LAMP)
    with pytest.raises(Unsupported):
        await ann.control.stop_all("nobody")


async def test_what_does_not_stop_is_named(line: Line, ann: Client) -> None:
    async def fail() -> None:
        raise ComponentFailed("the switch is stuck")

    line.lamp.stop = fail  # type: ignore[method-assign]
    with pytest.raises(ComponentFailed, match=r"toys/lamp: .*stuck"):
        await ann.control.stop_all("toys")
