"""Limits of connections for applications, adapters and addresses."""

import asyncio
from collections import Counter
from contextlib import AsyncExitStack
from typing import Any

import pytest
from aiohttp import web
from websockets.asyncio.client import connect

from openrois.gateway import server
from openrois.gateway.connection_limits import ENTERING, ConnectionLimits
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from tests.support.plain import attached, plain_adapter


@pytest.fixture
def turned_away() -> Counter[str]:
    return Counter()


@pytest.fixture
def limits(turned_away: Counter[str]) -> ConnectionLimits:
    return ConnectionLimits(lambda reason: turned_away.update((reason,)), applications=3, adapters=1, per_address=2)


def test_adapters_have_places_of_their_own(limits: ConnectionLimits, turned_away: Counter[str]) -> None:
    with (
        limits.of_application("a"),
        limits.of_application("a"),
        limits.of_application("b"),
    ):
        assert limits.is_full
        with pytest.raises(web.HTTPServiceUnavailable), limits.of_application("c"):
            pass
        with limits.of_adapter(), pytest.raises(web.HTTPServiceUnavailable), limits.of_adapter():
            pass
    assert not limits.is_full
    with limits.of_adapter():
        assert limits.is_full
        with limits.of_application("c"):
            pass
    assert turned_away == {"full": 2}


def test_one_address_has_so_many(limits: ConnectionLimits, turned_away: Counter[str]) -> None:
    with limits.of_application("a"), limits.of_application("a"):
        with pytest.raises(web.HTTPTooManyRequests), limits.of_application("a"):
            pass
        with limits.of_application("b"):
            pass
    with limits.of_application("a"):
        pass
    assert turned_away == {"too many from one address": 1}


async def test_of_a_crowd_a_few_come_in_at_a_time(limits: ConnectionLimits) -> None:
    inside: list[int] = []
    came: list[int] = []
    may_go = asyncio.Event()

    async def come(number: int) -> None:
        async with limits.entering():
            came.append(number)
            inside.append(number)
            assert len(inside) <= ENTERING
            await may_go.wait()
            inside.remove(number)

    async with asyncio.TaskGroup() as crowd:
        for number in range(20):
            crowd.create_task(come(number))
        gives_up = crowd.create_task(come(20))
        await asyncio.sleep(0)
        assert (came, limits.waiting) == (list(range(ENTERING)), 21 - ENTERING)
        gives_up.cancel()
        await asyncio.sleep(0)
        assert limits.waiting == 20 - ENTERING
        may_go.set()
    assert (came, limits.waiting) == (list(range(20)), 0)


async def test_an_adapter_does_not_wait_behind_a_crowd(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[ConnectionLimits] = []

    class Noted(ConnectionLimits):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            made.append(self)

    monkeypatch.setattr(server, "ConnectionLimits", Noted)
    async with run_gateway(GatewaySettings(port=0)) as gateway, AsyncExitStack() as stack:
        async with AsyncExitStack() as crowd:
            for _ in range(ENTERING):
                await crowd.enter_async_context(made[0].entering())
            app = asyncio.ensure_future(connect(gateway.url.replace("http", "ws", 1), proxy=None).__aenter__())
            await stack.enter_async_context(plain_adapter(gateway))
            await attached(gateway)
            assert not app.done()
        await (await app).close()
