"""Parts in the client: a person takes one from a program for a time, and the program goes on with it afterwards."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import pytest

from openrois.client import BindingLent, BindingLost, BindingRestored, BodyLost, Client, Notice
from openrois.errors import Aborted, OutOfResources
from openrois.gateway.applications import serve_application
from openrois.gateway.token_expiry import TokenExpiry
from openrois.transport.memory import memory_pair
from openrois.transport.stream import MessageStream
from openrois.types.leases import LeaseState
from tests.support import grounds
from tests.support.authorization import principal
from tests.support.grounds import Line

pytestmark = pytest.mark.extra(name="base")

LAMP = "toys/lamp"
Login = Callable[[str, str], AbstractAsyncContextManager[Client]]


@pytest.fixture
async def line() -> AsyncIterator[Line]:
    async with grounds.line(grace=10) as running:
        yield running


@pytest.fixture
def login(line: Line) -> Login:
    async def serve(far: MessageStream, who: TokenExpiry) -> None:
        await serve_application(line.host, far, who)

    def client(subject: str, rank: str) -> AbstractAsyncContextManager[Client]:
        @asynccontextmanager
        async def dial() -> AsyncIterator[MessageStream]:
            near, far = memory_pair()
            who = TokenExpiry(principal("operator", "*", subject=subject, rank=rank))
            line.tasks.start(serve(far, who))
            try:
                yield near
            finally:
                near.abort()

        return Client(dial=dial)

    return client


async def heard(notices: AsyncIterator[Notice]) -> Notice:
    async with asyncio.timeout(60):
        return await anext(notices)


async def test_a_program_is_told_and_goes_on_afterwards(line: Line, login: Login) -> None:
    async with login("night watch", "script") as program, login("ann", "person") as ann:
        notices = program.notices(BindingLent, BindingLost, BindingRestored)
        await program.bind(LAMP)
        running = await program.component(LAMP).command("start").execute()
        await line.lamp.glowing.wait()
        lease = await ann.control.borrow(LAMP, seconds=20)
        assert (lease.state, lease.lender) == (LeaseState.MINE, "night watch")
        told = await heard(notices)
        assert isinstance(told, BindingLent)
        assert (told.component_ref, told.holder) == (LAMP, "ann")
        assert 0 < told.seconds <= 20
        with pytest.raises(Aborted, match="higher rank"):
            await running
        with pytest.raises(OutOfResources, match="taken for a time by ann"):
            await program.component(LAMP).command("switch").execute()
        await ann.component(LAMP).command("switch", times=2)
        await ann.control.give_back(LAMP)
        assert await heard(notices) == BindingRestored(LAMP)
        await program.component(LAMP).command("switch", times=3)
        assert line.lamp.total == 5


async def test_a_body_of_which_a_part_is_lent_is_not_lost(login: Login) -> None:
    async with login("night watch", "script") as program, login("ann", "person") as ann:
        notices = program.notices(BindingLent, BindingRestored, BodyLost)
        async with program.body("Navigation") as body:
            ref = body["Navigation"].component_ref
            await ann.control.borrow(ref)
            assert isinstance(await heard(notices), BindingLent)
            await ann.control.give_back(ref)
            assert await heard(notices) == BindingRestored(ref)
            assert body.error is None


async def test_what_does_not_come_back_is_lost(line: Line, login: Login) -> None:
    async with login("night watch", "script") as program, login("ann", "person") as ann:
        notices = program.notices(BindingLost)
        await program.bind(LAMP)
        await ann.control.borrow(LAMP)
        async with Client(dial=line.dial) as admin:
            await admin.control.take(LAMP)
            lost = await heard(notices)
            assert isinstance(lost, BindingLost)
            assert "administrator" in str(lost.error)


async def test_a_borrower_is_told_when_its_time_is_over(login: Login) -> None:
    async with login("night watch", "script") as program, login("ann", "person") as ann:
        notices = ann.notices(BindingLost)
        await program.bind(LAMP)
        await ann.control.borrow(LAMP, seconds=0.001)
        lost = await heard(notices)
        assert isinstance(lost, BindingLost)
        assert lost.component_ref == LAMP
