"""The configuration of haproxy that is shipped: haproxy takes it, and what it does before gateways that stand in."""

import asyncio
import subprocess
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import pytest

from tests.support.proxies import ShippedProxy, shipped, shipped_proxy

pytestmark = pytest.mark.usefixtures("haproxy")

PATIENCE = 25.0
"""Seconds for what is to happen; less than those after which the proxy cuts what is silent."""


class Gateway:
    """Stands in for a gateway: it answers probes as it is told, and keeps every other connection.

    Attributes:
        url: its address.
        ready: the answer to `/readyz`; 0 for none, to `/healthz` neither.
    """

    def __init__(self) -> None:
        self.url = ""
        self.ready = 200
        self._server: asyncio.Server | None = None
        self._serving: set[asyncio.Task[None]] = set()

    async def start(self) -> None:
        """Listen, where it did before."""
        port = int(self.url.rpartition(":")[2].strip("/") or 0)
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", port)
        self.url = f"http://127.0.0.1:{self._server.sockets[0].getsockname()[1]}/"

    async def stop(self) -> None:
        """End, and with it every connection."""
        assert self._server is not None
        self._server.close()
        for task in self._serving:
            task.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)
        await self._server.wait_closed()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._serving.add(task)
        try:
            line = await reader.readline()
            if self.ready and line:
                status = self.ready if b"/readyz" in line else 200
                writer.write(f"HTTP/1.0 {status} As told\r\nContent-Length: 0\r\n\r\n".encode())
                await writer.drain()
            elif line:
                await reader.read()
        except ConnectionResetError:
            # A check whose time is over.
            pass
        finally:
            self._serving.discard(task)
            writer.close()


class Application:
    """A connection over which nothing is sent."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._writer = writer
        self.ended = asyncio.ensure_future(reader.read())

    @classmethod
    @asynccontextmanager
    async def connected(cls, front: ShippedProxy, address: str = "127.0.0.1") -> "AsyncIterator[Application]":
        """Connect from an address while the block runs."""
        host, _, port = front.url.removeprefix("http://").strip("/").rpartition(":")
        reader, writer = await asyncio.open_connection(host, int(port), local_addr=(address, 0))
        made = cls(reader, writer)
        try:
            yield made
        finally:
            made.ended.cancel()
            writer.close()


@asynccontextmanager
async def standing() -> AsyncIterator[tuple[list[Gateway], ShippedProxy]]:
    """Have three gateways that are ready behind the proxy."""
    async with AsyncExitStack() as stack:
        gateways = [Gateway() for _ in "abc"]
        for gateway in gateways:
            await gateway.start()
            stack.push_async_callback(gateway.stop)
        front = await stack.enter_async_context(shipped_proxy(*(each.url for each in gateways)))
        await front.takes_for("UP", "UP", "UP")
        await front.takes_for("UP", "UP", "UP", backend="living")
        yield gateways, front


async def cut(*applications: Application) -> Application:
    """Wait until one of these is cut off, and return it."""
    waiting = {each.ended: each for each in applications}
    ended, _ = await asyncio.wait(waiting, timeout=PATIENCE, return_when=asyncio.FIRST_COMPLETED)
    (only,) = ended
    return waiting[only]


def test_haproxy_takes_it_as_it_is(tmp_path: Path) -> None:
    text = shipped(("https://127.0.0.1:1/", "https://127.0.0.1:2/", "https://127.0.0.1:3/"), 4, tmp_path / "socket")
    assert "check-ssl verify none" in text
    there = tmp_path / "haproxy.cfg"
    there.write_text(text)
    said = subprocess.run(["haproxy", "-c", "-f", str(there)], capture_output=True, text=True, check=False)
    assert (said.returncode, said.stderr) == (0, "")


async def test_a_gateway_that_is_not_ready_keeps_its_connections_and_gets_no_more() -> None:
    async with standing() as (gateways, front), AsyncExitStack() as stack:
        there = [await stack.enter_async_context(Application.connected(front)) for _ in "abc"]
        await front.spread([1, 1, 1].__eq__)
        gateways[0].ready = 503
        await front.takes_for("NOLB", "UP", "UP")
        more = [await stack.enter_async_context(Application.connected(front)) for _ in "1234"]
        await front.spread([1, 3, 3].__eq__)
        assert not [each for each in (*there, *more) if each.ended.done()]
        gateways[0].ready = 200
        await front.takes_for("UP", "UP", "UP")
        more.append(await stack.enter_async_context(Application.connected(front)))
        await front.spread([2, 3, 3].__eq__)


async def test_where_none_is_ready_connections_stay_and_new_ones_come_to_gateways_that_live() -> None:
    async with standing() as (gateways, front), AsyncExitStack() as stack:
        there = await stack.enter_async_context(Application.connected(front))
        own = (await front.spread(any)).index(1)
        for gateway in gateways:
            gateway.ready = 503
        await front.takes_for("NOLB", "NOLB", "NOLB")
        more = [await stack.enter_async_context(Application.connected(front)) for _ in "123"]
        await front.spread([1, 1, 1].__eq__, "living")
        assert not [each for each in (there, *more) if each.ended.done()]
        # One that does not answer at all is cut here, too.
        silent = (own + 1) % 3
        gateways[silent].ready = 0
        more.remove(await cut(*more))
        await front.spread([int(number != silent) for number in range(3)].__eq__, "living")
        assert not [each for each in (there, *more) if each.ended.done()]
        for gateway in gateways:
            gateway.ready = 200
        await front.takes_for("UP", "UP", "UP")
        for _ in "12":
            await stack.enter_async_context(Application.connected(front))
        await front.spread([1, 1, 1].__eq__)


@pytest.mark.long
async def test_connections_of_a_gateway_that_does_not_answer_are_cut() -> None:
    async with standing() as (gateways, front), AsyncExitStack() as stack:
        there = [await stack.enter_async_context(Application.connected(front)) for _ in "abc"]
        gateways[0].ready = 0
        there.remove(await cut(*there))
        await front.takes_for("DOWN", "UP", "UP")
        await front.spread([0, 1, 1].__eq__)
        assert not [each for each in there if each.ended.done()]


async def test_a_gateway_that_has_just_ended_is_passed_over_at_once() -> None:
    async with standing() as (gateways, front), AsyncExitStack() as stack:
        await gateways[0].stop()
        there = [await stack.enter_async_context(Application.connected(front)) for _ in "1234"]
        await front.spread([0, 2, 2].__eq__)
        assert not [each for each in there if each.ended.done()]
        await gateways[0].start()


async def test_a_weight_is_a_share_and_can_be_changed_while_it_runs() -> None:
    async with standing() as (_gateways, front), AsyncExitStack() as stack:
        assert await front.shown("weight") == {"a": "100", "b": "100", "c": "100"}
        assert await front.ask("set server ready/c weight 10") == "\n"
        for _ in range(21):
            await stack.enter_async_context(Application.connected(front))
        await front.spread([10, 10, 1].__eq__)


async def test_an_address_has_as_many_connections_as_at_a_gateway() -> None:
    async with standing() as (_gateways, front), AsyncExitStack() as stack:
        there = [await stack.enter_async_context(Application.connected(front)) for _ in range(1024)]
        await front.spread(lambda counts: sum(counts) == 1024)
        with pytest.raises(ConnectionResetError):
            async with Application.connected(front) as one_more:
                await asyncio.wait_for(one_more.ended, PATIENCE)
        other = await stack.enter_async_context(Application.connected(front, "127.0.0.2"))
        await front.spread(lambda counts: sum(counts) == 1025)
        assert not [each for each in (*there, other) if each.ended.done()]
