"""A client before it is connected and after it was closed: it says so at once, and how to go on."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from openrois.client import Client, ConnectionLost, ConnectionState
from openrois.client.components import Navigation
from tests.support.grounds import Line

pytestmark = pytest.mark.extra(name="base")

USES: dict[str, Callable[[Client], Awaitable[Any]]] = {
    "bind": lambda client: client.bind("robot/navigation"),
    "call": lambda client: client.call("rois.system.get_profile"),
    "control": lambda client: client.control.stop_all(),
    "execute": lambda client: client.run(client.component(Navigation, "robot/navigation").start()),
    "find": lambda client: client.find(Navigation, within=60),
    "profile": lambda client: client.get_profile(),
    "query": lambda client: client.component(Navigation, "robot/navigation").component_status(),
    "search": lambda client: client.search(),
    "set": lambda client: client.component(Navigation, "robot/navigation").set(time_limit=1).execute(),
    "subscribe": lambda client: anext(client.component(Navigation, "robot/navigation").reached_target()),
}
HOW = r"the client is not connected: use it in `async with client:`, or `await client\.connect\(\)` first$"


@pytest.mark.parametrize("use", USES)
async def test_a_client_that_is_not_connected_says_how_at_once(use: str, line: Line) -> None:
    client = Client(dial=line.dial)
    async with asyncio.timeout(5):
        with pytest.raises(ConnectionLost, match=HOW):
            await USES[use](client)
    assert line.dialled == 0


def test_it_has_no_feeds_either(line: Line) -> None:
    client = Client(dial=line.dial)
    with pytest.raises(ConnectionLost, match=HOW):
        client.notices()
    with pytest.raises(ConnectionLost, match=HOW):
        client.notifications()


@pytest.mark.parametrize("use", USES)
async def test_one_that_was_closed_says_that(use: str, line: Line) -> None:
    async with Client(dial=line.dial) as client:
        pass
    async with asyncio.timeout(5):
        with pytest.raises(ConnectionLost, match="the client is closed"):
            await USES[use](client)


async def test_connect_and_close_do_what_the_block_does(line: Line) -> None:
    client = await Client(dial=line.dial).connect()
    assert client.state is ConnectionState.CONNECTED
    assert "robot/navigation" in await client.search()
    await client.close()
    await client.close()
    assert client.state is ConnectionState.CLOSED
    with pytest.raises(RuntimeError, match="this client was used before: make another one"):
        await client.connect()


async def test_one_that_was_closed_before_it_was_connected_stays_closed(line: Line) -> None:
    client = Client(dial=line.dial)
    await client.close()
    with pytest.raises(RuntimeError, match="this client was used before"):
        await client.connect()
    with pytest.raises(ConnectionLost, match="search: the client is closed"):
        await client.search()
