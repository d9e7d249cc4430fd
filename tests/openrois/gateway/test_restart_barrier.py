"""A gateway that is started again: its adapters come before its applications, if they come at all."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import aiohttp
import pytest

from openrois.gateway import restart_barrier as module
from openrois.gateway.server import Gateway
from openrois.journal.file import JournalFile
from openrois.journal.records import Presence
from tests.support import deployment
from tests.support.deployment import Robot, adapter, application, until


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


def known(path: Path) -> frozenset[str]:
    journal = JournalFile(path)
    journal.close()
    return journal.engines


def before(path: Path, *engine_ids: str) -> None:
    """Leave a journal as a gateway does that is killed while these engines are there."""
    journal = JournalFile(path)
    journal.write([Presence(engine_id, is_there=True) for engine_id in engine_ids])
    journal.close()


async def ready(gateway: Gateway) -> bool:
    async with aiohttp.ClientSession() as http, http.get(f"{gateway.url}readyz") as response:
        return response.status == 200


@asynccontextmanager
async def knocking(gateway: Gateway) -> AsyncIterator["asyncio.Task[list[str]]"]:
    """An application that comes in as soon as it may, and finds these engines."""

    async def come_in() -> list[str]:
        async with application(gateway) as app:
            profile = (await app.ask("rois.system.get_profile", condition=""))["profile"]
            return [below["identifier"]["code"] for below in profile["sub_profiles"]]

    async with asyncio.TaskGroup() as tasks:
        yield tasks.create_task(come_in())


async def test_applications_wait_for_the_adapters_that_were_there(path: Path) -> None:
    before(path, "robot")
    async with deployment.gateway(journal=path) as gateway, knocking(gateway) as app:
        assert not await ready(gateway)
        async with adapter(gateway, *Robot().parts()):
            assert await app == ["robot"]
            assert await ready(gateway)


async def test_an_adapter_that_stays_away_is_waited_for_once(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "RETURN_TIME", 0.05)
    before(path, "robot")
    async with deployment.gateway(journal=path) as gateway, knocking(gateway) as app:
        assert await app == []
        assert await ready(gateway)
    assert known(path) == frozenset()


async def test_engines_at_the_end_are_kept_and_departed_ones_are_not(path: Path) -> None:
    async with AsyncExitStack() as stack, AsyncExitStack() as ending_first:
        gateway = await ending_first.enter_async_context(deployment.gateway(journal=path))
        await stack.enter_async_context(adapter(gateway, *Robot().parts()))
        async with adapter(gateway, engine_id="rover"):
            assert await ready(gateway)
        await until(gateway.engine, lambda ids: "rover" not in ids)
    assert known(path) == {"robot"}


async def test_an_engine_closed_for_a_restart_is_kept(path: Path) -> None:
    async with deployment.gateway(journal=path) as gateway, adapter(gateway, *Robot().parts()):
        await gateway.drain()
    assert known(path) == {"robot"}
