"""Dialling a gateway, again and again, on a clock that the test turns."""

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import InvalidURI

from openrois.adapter.dialer import serve_parent
from openrois.adapter.rotation import LONGEST_WAIT
from openrois.engine.engine import Engine
from openrois.session.session import EngineHost
from tests.support.demo import free_port
from tests.support.wire import hosted

pytestmark = pytest.mark.extra(name="gateway")


class Time:
    """Delays are noted and pass at once, until there were `enough` of them."""

    def __init__(self, enough: int) -> None:
        self.now = 0.0
        self.delays: list[float] = []
        self.enough = asyncio.Event()
        self._count = enough

    async def sleep(self, seconds: float) -> None:
        self.delays.append(seconds)
        self.now += seconds
        if len(self.delays) >= self._count:
            self.enough.set()
            await asyncio.Event().wait()
        await asyncio.sleep(0)

    def clock(self) -> float:
        return self.now


@asynccontextmanager
async def dialling(host: EngineHost, *urls: str, time: Time) -> AsyncIterator[None]:
    running = asyncio.ensure_future(serve_parent(host, *urls, sleep=time.sleep, clock=time.clock, chance=lambda: 1.0))
    try:
        async with asyncio.timeout(60):
            await time.enough.wait()
        yield
    finally:
        running.cancel()
        await asyncio.wait({running})


@pytest.fixture
async def host() -> AsyncIterator[EngineHost]:
    async with hosted(Engine("robot")) as made:
        yield made


async def test_no_gateway_listens(host: EngineHost, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)

    async def never(_far: ServerConnection) -> None:
        raise AssertionError

    async with serve(never, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
    time = Time(enough=6)
    async with dialling(host, f"ws://127.0.0.1:{port}/adapter", time=time):
        assert time.delays == [0.25, 0.375, 0.5625, 0.84375, 1, 1]
    assert len([line for line in caplog.messages if line.startswith("trying again")]) == 3, "the attempts 1, 2 and 4"
    assert f"no gateway answers at ws://127.0.0.1:{port}/adapter; `openrois gateway` starts one here" in caplog.text


async def test_something_else_listens(host: EngineHost, caplog: pytest.LogCaptureFixture) -> None:
    async def not_a_websocket(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"nonsense\r\n\r\n")
        writer.close()

    async with await asyncio.start_server(not_a_websocket, "127.0.0.1", 0) as server:
        time = Time(enough=2)
        async with dialling(host, f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter", time=time):
            assert time.delays == [1, 1.5]
    assert "/adapter is no gateway" in caplog.text


async def test_a_refusal_counts_as_a_failure_and_a_lasting_connection_as_success(
    host: EngineHost, caplog: pytest.LogCaptureFixture
) -> None:
    time = Time(enough=4)
    lasts = iter([0, 0, 10, 0])

    async def refuse(far: ServerConnection) -> None:
        await far.send('{"jsonrpc":"2.0","id":1,"method":"rois.system.connect"}')
        await far.recv()
        time.now += next(lasts)
        await far.close(1008, "the engine id is taken")

    async with serve(refuse, "127.0.0.1", 0) as server:
        url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
        async with dialling(host, url, time=time):
            assert time.delays == [1, 1.5, 1, 1.5]
    assert caplog.messages.count("the gateway refuses this adapter: the engine id is taken") == 4


async def test_a_gateway_that_restarts_says_when_to_come_back(host: EngineHost) -> None:
    time = Time(enough=2)

    async def restart(far: ServerConnection) -> None:
        await far.close(1012, "retry_after=0.75")

    async with serve(restart, "127.0.0.1", 0) as server:
        url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
        async with dialling(host, url, time=time):
            assert time.delays == [1.0, 1.125]


async def test_an_attempt_that_takes_long_is_no_lasting_connection(host: EngineHost) -> None:
    time = Time(enough=3)

    async def hang_up_at_length(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        time.now += 10
        writer.close()

    async with await asyncio.start_server(hang_up_at_length, "127.0.0.1", 0) as server:
        url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
        async with dialling(host, url, time=time):
            assert time.delays == [0.25, 0.375, 0.5625]


@pytest.mark.parametrize("outage", [0.0, 0.3, 1.0, 4.0, 60.0, 3600.0])
async def test_however_long_there_was_no_gateway_it_is_found_soon(host: EngineHost, outage: float) -> None:
    """The longest waits that chance allows: what is measured is the rest of one when the gateway listens again."""
    found = asyncio.Event()

    async def take(far: ServerConnection) -> None:
        found.set()
        await far.wait_closed()

    port, now, listening = free_port(), 0.0, None

    async def sleep(seconds: float) -> None:
        nonlocal now, listening
        now += seconds
        if now >= outage and listening is None:
            listening = await serve(take, "127.0.0.1", port)

    url = f"ws://127.0.0.1:{port}/adapter"
    running = asyncio.ensure_future(serve_parent(host, url, sleep=sleep, clock=lambda: now, chance=lambda: 1.0))
    try:
        async with asyncio.timeout(60):
            await found.wait()
    finally:
        running.cancel()
        await asyncio.wait({running})
        assert listening is not None
        listening.close()
        await listening.wait_closed()
    assert now - outage <= LONGEST_WAIT < 3


@pytest.mark.parametrize(
    ("status", "waits"), [(503, [0.25, 0.375]), (502, [0.25, 0.375]), (401, [1, 1.5]), (404, [1, 1.5])]
)
async def test_a_gateway_that_ends_is_no_refusal(host: EngineHost, status: int, waits: list[float]) -> None:
    async def never(_far: ServerConnection) -> None:
        raise AssertionError

    async with serve(never, "127.0.0.1", 0, process_request=lambda far, _: far.respond(status, "no\n")) as server:
        url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
        time = Time(enough=2)
        async with dialling(host, url, time=time):
            assert time.delays == waits


class TestSeveralGateways:
    async def test_one_that_drains_sends_the_adapter_to_the_next_at_once(
        self, host: EngineHost, caplog: pytest.LogCaptureFixture
    ) -> None:
        caplog.set_level(logging.INFO)
        time, found = Time(enough=1), asyncio.Event()

        async def drain(far: ServerConnection) -> None:
            await far.close(1012, "retry_after=60")

        async def take(far: ServerConnection) -> None:
            found.set()
            await far.wait_closed()

        async with serve(drain, "127.0.0.1", 0) as first, serve(take, "127.0.0.1", 0) as second:
            urls = [f"ws://127.0.0.1:{each.sockets[0].getsockname()[1]}/adapter" for each in (first, second)]
            running = asyncio.ensure_future(
                serve_parent(host, *urls, sleep=time.sleep, clock=time.clock, chance=lambda: 1.0)
            )
            async with asyncio.timeout(60):
                await found.wait()
            assert (time.delays, running.done()) == ([], False)
            assert caplog.messages.count(f"trying {urls[1]}") == 1
            running.cancel()
            await asyncio.wait({running})

    async def test_there_is_a_pause_after_a_round_in_which_none_was_there(self, host: EngineHost) -> None:
        urls = [f"ws://127.0.0.1:{free_port()}/adapter" for _ in range(3)]
        time = Time(enough=3)
        async with dialling(host, *urls, time=time):
            assert time.delays == [0.25, 0.375, 0.5625]

    async def test_one_that_cannot_own_its_engine_says_when_to_come_back(self, host: EngineHost) -> None:
        time = Time(enough=1)

        async def refuse(far: ServerConnection) -> None:
            await far.close(1013, "retry_after=2.00 robot is owned by gateway a")

        async with serve(refuse, "127.0.0.1", 0) as server:
            url = f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/adapter"
            async with dialling(host, url, time=time):
                assert time.delays == [2.25]


async def test_an_address_that_is_none_is_a_mistake(host: EngineHost) -> None:
    with pytest.raises(InvalidURI):
        await serve_parent(host, "http://127.0.0.1/adapter")
