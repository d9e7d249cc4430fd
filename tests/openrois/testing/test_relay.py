"""The fault relay in front of a server that echoes."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import pytest

from openrois.testing import FaultRelay, Weather
from openrois.testing import relay as relay_module
from tests.support.clock import Clock

pytestmark = pytest.mark.extra(name="base")

PATIENCE = 5.0


@asynccontextmanager
async def echo() -> AsyncIterator[str]:
    """Run a server that sends back what it gets; yields its address."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while data := await reader.read(1 << 16):
                writer.write(data)
                await writer.drain()
            writer.write(b"bye")
        except ConnectionError:
            pass
        finally:
            writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    try:
        yield f"tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}/path"
    finally:
        server.close()


@asynccontextmanager
async def through(relay: FaultRelay) -> AsyncIterator[tuple[asyncio.StreamReader, asyncio.StreamWriter]]:
    reader, writer = await asyncio.open_connection("127.0.0.1", relay.port)
    try:
        yield reader, writer
    finally:
        writer.transport.abort()


async def say(pair: tuple[asyncio.StreamReader, asyncio.StreamWriter], text: bytes) -> bytes:
    pair[1].write(text)
    async with asyncio.timeout(PATIENCE):
        return await pair[0].readexactly(len(text))


@pytest.mark.parametrize("weather", [Weather(), Weather(chop=3), Weather(delay=0.001, jitter=0.003), Weather(rate=1e6)])
async def test_what_passes_stays_whole_and_in_order(weather: Weather) -> None:
    text = bytes(range(256)) * 8
    async with echo() as url, FaultRelay(url, seed=7, weather=weather) as relay:
        assert relay.url == f"tcp://127.0.0.1:{relay.port}/path"
        async with through(relay) as pair:
            assert await say(pair, text) == text
            pair[1].write_eof()
            async with asyncio.timeout(PATIENCE):
                assert await pair[0].read() == b"bye"


async def test_a_cut_resets_both_ends_and_lets_the_next_pass() -> None:
    async with echo() as url, FaultRelay(url) as relay:
        async with through(relay) as pair:
            assert await say(pair, b"one") == b"one"
            assert len(relay) == 1
            relay.cut(refuse=True)
            async with asyncio.timeout(PATIENCE):
                with suppress(ConnectionResetError):
                    assert await pair[0].read(1) == b""
        async with through(relay) as pair, asyncio.timeout(PATIENCE):
            with suppress(ConnectionResetError):
                assert await pair[0].read(1) == b""
        relay.mend()
        async with through(relay) as pair:
            assert await say(pair, b"two") == b"two"
        assert relay.accepted == 2


async def test_a_half_open_connection_swallows_bytes_and_its_own_end() -> None:
    async with echo() as url, FaultRelay(url) as relay, through(relay) as pair, through(relay) as other:
        assert await say(pair, b"one") == b"one"
        assert await say(other, b"one") == b"one"
        relay.half_open()
        pair[1].write(b"two")
        pair[1].write_eof()
        async with through(relay) as late:
            late[1].write(b"late")
            relay.mend()
            async with through(relay) as healthy:
                assert await say(healthy, b"three") == b"three"
            assert relay.swallowed == len(b"twolate")
            for reader in (pair[0], other[0], late[0]):
                assert not reader.at_eof()
                assert not reader._buffer  # type: ignore[attr-defined]


async def test_the_same_seed_chops_alike() -> None:
    async with echo() as url:
        chopped = [FaultRelay(url, seed=seed)._chopped(bytes(100), 9) for seed in (1, 1, 2)]
    assert chopped[0] == chopped[1] != chopped[2]


async def test_pieces_travel_as_long_as_the_weather_says() -> None:
    clock, waited = Clock(), list[float]()

    async def sleep(seconds: float) -> None:
        waited.append(round(seconds, 6))
        clock.now += seconds

    travelling = Weather(delay=2.0)
    async with (
        echo() as url,
        FaultRelay(url, weather=travelling, clock=clock, sleep=sleep) as relay,
        through(relay) as pair,
    ):
        assert await say(pair, b"x") == b"x"
        assert waited == [2.0, 2.0]
        relay.change(delay=0.0, rate=0.5)
        assert await say(pair, b"yz") == b"yz"
        assert waited[2:] == [4.0, 4.0]


async def test_a_server_that_is_not_there_is_refused() -> None:
    async with echo() as url:
        pass
    async with FaultRelay(url) as relay, through(relay) as pair, asyncio.timeout(PATIENCE):
        with suppress(ConnectionError):
            assert await pair[0].read(1) == b""


async def test_only_so_many_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(relay_module, "MAX_CONNECTIONS", 1)
    async with echo() as url, FaultRelay(url) as relay, through(relay) as one:
        assert await say(one, b"x") == b"x"
        async with through(relay) as two, asyncio.timeout(PATIENCE):
            with suppress(ConnectionError):
                assert await two[0].read(1) == b""
        assert relay.accepted == 1


async def test_what_is_used_wrongly_says_so() -> None:
    with pytest.raises(ValueError, match="names no host and port"):
        FaultRelay("nowhere")
    with pytest.raises(RuntimeError, match="not been entered"):
        FaultRelay("tcp://127.0.0.1:1").port.bit_length()
