"""A demo's programs that run and do not do what they should, in front of a real gateway in this process."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import pytest
from openrois_avatar.attendance import Attendance

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


@asynccontextmanager
async def watching(url: str, *, patience: float) -> AsyncIterator[tuple[Attendance, Watched, Watched]]:
    attendance = Attendance(url.replace("http", "ws", 1), patience=patience, sleep=lambda _seconds: asyncio.sleep(0))
    gateway, avatar = Watched("gateway"), Watched("avatar")
    task = asyncio.ensure_future(attendance.watch(gateway, avatar))
    try:
        yield attendance, gateway, avatar
    finally:
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task


async def test_an_avatar_that_leaves_and_does_not_come_back_is_ended(caplog: pytest.LogCaptureFixture) -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell()) as adapter,
        watching(gateway.url, patience=0.01) as (attendance, gateway_program, avatar),
        asyncio.timeout(5),
    ):
        await attendance.until_there()
        with caplog.at_level(logging.WARNING):
            await adapter.stop()
            await avatar.killed.wait()
        assert "avatar runs and is not there: it is ended, and started again" in caplog.messages
        await adapter.start()
        await attendance.until_there()
        avatar.killed.clear()
        await adapter.stop()
        await avatar.killed.wait()
        assert not gateway_program.killed.is_set()


async def test_one_that_was_started_again_has_its_time() -> None:
    async with (
        deployment.gateway() as gateway,
        deployment.adapter(gateway, Bell()) as adapter,
        watching(gateway.url, patience=0.05) as (attendance, _, avatar),
        asyncio.timeout(5),
    ):
        await attendance.until_there()
        await adapter.stop()
        await attendance._avatar.missing.wait()
        avatar.runs += 1
        await asyncio.sleep(0.1)
        assert not avatar.killed.is_set()


async def test_a_gateway_that_does_not_answer_is_ended_and_nobody_blames_the_avatar() -> None:
    async with deployment.gateway() as gateway, deployment.adapter(gateway, Bell()):
        watched = watching(gateway.url, patience=0.05)
        attendance, gateway_program, avatar = await watched.__aenter__()
        async with asyncio.timeout(5):
            await attendance.until_there()
    try:
        async with asyncio.timeout(5):
            await gateway_program.killed.wait()
        assert not avatar.killed.is_set()
    finally:
        await watched.__aexit__(None, None, None)
