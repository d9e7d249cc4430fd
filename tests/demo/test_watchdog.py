"""A demo's programs that run and do not do what they should, in front of a real gateway in this process."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress

import pytest
from openrois_demo.watchdog import PATIENCE, START, Watchdog

from tests.support import deployment
from tests.support.components import Bell


class Watched:
    """Stands in for a program."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.runs = 1
        self.killed = asyncio.Event()

    def kill(self) -> None:
        self.killed.set()


class Time:
    """Passes when a test says so.

    Attributes:
        patience: it is over.
        starting: a program that was ended is given time to begin.
    """

    def __init__(self) -> None:
        self.patience = asyncio.Event()
        self.starting = asyncio.Event()

    async def sleep(self, seconds: float) -> None:
        if seconds == PATIENCE:
            await self.patience.wait()
        elif seconds == START:
            self.starting.set()
            await deployment.forever()
        else:
            await asyncio.sleep(0)


@asynccontextmanager
async def watching(url: str, *others: str) -> AsyncIterator[tuple[Watchdog, Time, Watched, Watched]]:
    passing = Time()
    watchdog = Watchdog(url.replace("http", "ws", 1), ["avatar", *others], sleep=passing.sleep)
    gateway, avatar = Watched("gateway"), Watched("avatar")
    adapters = {"avatar": avatar, **{name: Watched(name) for name in others}}
    task = asyncio.ensure_future(watchdog.watch(gateway, adapters))
    try:
        async with deployment.patience():
            await watchdog.until_there()
            yield watchdog, passing, gateway, avatar
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def test_an_avatar_that_leaves_and_does_not_come_back_is_ended(caplog: pytest.LogCaptureFixture) -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell(), engine_id="avatar") as adapter,
        watching(gateway.url) as (watchdog, time, gateway_program, avatar),
    ):
        time.patience.set()
        with caplog.at_level(logging.WARNING):
            await adapter.stop()
            await avatar.killed.wait()
        assert "avatar runs but does not answer: it is killed, and started again" in caplog.messages
        await adapter.start()
        await watchdog.until_there()
        avatar.killed.clear()
        await adapter.stop()
        await avatar.killed.wait()
        assert not gateway_program.killed.is_set()


async def test_restarted_program_has_time_to_come_back() -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell(), engine_id="avatar") as adapter,
        watching(gateway.url) as (watchdog, time, _, avatar),
    ):
        await adapter.stop()
        await watchdog._adapters["avatar"].missing.wait()
        avatar.runs += 1
        time.patience.set()
        await time.starting.wait()
        assert not avatar.killed.is_set()


async def test_gateway_without_answer_is_ended_and_the_avatar_is_not() -> None:
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(deployment.gateway())
        adapter = await stack.enter_async_context(deployment.adapter(gateway, Bell(), engine_id="avatar"))
        async with watching(gateway.url) as (watchdog, time, gateway_program, avatar):
            await adapter.stop()
            await watchdog._adapters["avatar"].missing.wait()
            await stack.aclose()
            await watchdog._gateway.missing.wait()
            time.patience.set()
            await gateway_program.killed.wait()
            assert not avatar.killed.is_set()


async def test_of_two_bodies_the_one_that_is_missing_is_ended() -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell(), engine_id="robot") as robot,
        deployment.adapter(gateway, Bell(), engine_id="avatar") as adapter,
        watching(gateway.url, "robot") as (watchdog, time, gateway_program, avatar),
    ):
        time.patience.set()
        await adapter.stop()
        await avatar.killed.wait()
        assert not gateway_program.killed.is_set()
        assert robot.dialling is not None
        assert watchdog._adapters["robot"].there.is_set()


async def test_it_is_all_there_when_the_last_body_is() -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell(), engine_id="avatar"),
    ):
        watchdog = Watchdog(gateway.url.replace("http", "ws", 1), ["avatar", "robot"])
        programs = {name: Watched(name) for name in ("avatar", "robot")}
        watching_over = asyncio.ensure_future(watchdog.watch(Watched("gateway"), programs))
        there = asyncio.ensure_future(watchdog.until_there())
        try:
            async with deployment.patience():
                await watchdog._adapters["avatar"].there.wait()
                assert not there.done()
                async with deployment.adapter(gateway, Bell(), engine_id="robot"):
                    await there
        finally:
            watching_over.cancel()
            await asyncio.wait({watching_over})
