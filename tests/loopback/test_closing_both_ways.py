"""A viewer closes its peer connection while aiortc closes ours by itself and we do too: no task may fail."""

import asyncio
import gc
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from openrois_streaming.peer import connection as connection_module

from tests.support import loopback
from tests.support.loopback import Engine, Viewer

pytestmark = pytest.mark.media


def session_ends_meanwhile(turns: int) -> Callable[[Engine, Viewer], Awaitable[None]]:
    """The session ends so many turns of the loop after its peer connection began to close."""

    async def end(engine: Engine, viewer: Viewer) -> None:
        (connection,) = viewer.connections.values()
        closing = asyncio.ensure_future(connection.close())
        await engine.news.until(lambda: engine.byes)
        for _ in range(turns):
            await asyncio.sleep(0)
        await engine.session.close("the application is gone")
        await closing

    return end


async def both_sides_close_at_once(engine: Engine, viewer: Viewer) -> None:
    (connection,) = viewer.connections.values()
    async with asyncio.timeout(60):
        await asyncio.gather(connection.close(), engine.session.close("the application is gone"))


async def watched(end: Callable[[Engine, Viewer], Awaitable[None]]) -> list[dict[str, Any]]:
    """Play, end, and return the failures of tasks that are not awaited."""
    mishaps: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: mishaps.append(context))
    await play_and(end)
    gc.collect()
    return mishaps


async def play_and(end: Callable[[Engine, Viewer], Awaitable[None]]) -> None:
    async with loopback.engine() as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays()
        await end(engine, viewer)


@pytest.mark.parametrize("end", [both_sides_close_at_once, *map(session_ends_meanwhile, (0, 4, 6, 8))])
async def test_second_closing_waits_for_the_first(end: Callable[[Engine, Viewer], Awaitable[None]]) -> None:
    assert await watched(end) == []


async def test_a_close_that_takes_too_long_is_left_to_finish(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(connection_module, "CLOSE_TIMEOUT", 0.0)
    assert await watched(session_ends_meanwhile(0)) == []
    assert "a peer connection is not closed after 0 s" in caplog.messages
