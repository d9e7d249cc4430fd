import asyncio
from contextlib import suppress
from urllib.parse import urlsplit

import aiohttp
import pytest

from openrois.http_limits import header_timeout
from openrois.metrics.server import MAX_SCRAPES, MetricsUnavailable, metrics_address, serving_metrics

pytestmark = pytest.mark.extra(name="gateway")


async def write(accept: str) -> tuple[bytes, str]:
    return f"openrois_x 1 {accept}\n".encode(), "text/plain; version=0.0.4"


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("9464", ("127.0.0.1", 9464)),
        (":9464", ("127.0.0.1", 9464)),
        ("0.0.0.0:9464", ("0.0.0.0", 9464)),
        ("[::1]:0", ("::1", 0)),
        ("avatar.example:80", ("avatar.example", 80)),
    ],
)
def test_an_address_is_of_this_machine_alone_unless_it_says_otherwise(text: str, address: tuple[str, int]) -> None:
    assert metrics_address(text) == address


@pytest.mark.parametrize("text", ["", "x", "1.2.3.4:", "localhost:http", "65536", "-1", "²"])
def test_what_is_no_address_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="no address for metrics"):
        metrics_address(text)


async def test_figures_are_at_metrics_and_nothing_else_is_there() -> None:
    async with serving_metrics("127.0.0.1", 0, write) as url, aiohttp.ClientSession() as http:
        bodies = await asyncio.gather(*(_get(http, url) for _ in range(3)))
        assert all(body.startswith(b"openrois_x 1 */*") for body in bodies)
        async with http.get(url.removesuffix("metrics")) as response:
            assert response.status == 404


async def test_a_port_that_is_taken_is_said() -> None:
    async with serving_metrics("127.0.0.1", 0, write) as url:
        port = int(url.split(":")[2].partition("/")[0])
        with pytest.raises(MetricsUnavailable, match=f"metrics cannot be served at 127.0.0.1:{port}"):
            async with serving_metrics("127.0.0.1", port, write):
                pytest.fail("served")


async def _get(http: aiohttp.ClientSession, url: str) -> bytes:
    async with http.get(url) as response:
        assert response.headers["Content-Type"].startswith("text/plain")
        return await response.read()


async def test_a_token_is_asked_for_where_there_is_one() -> None:
    async with serving_metrics("127.0.0.1", 0, write, "s" * 16) as url, aiohttp.ClientSession() as http:
        for shown, status in (("", 401), ("Bearer sss", 401), ("Bearer ü", 401), ("Bearer " + "s" * 16, 200)):
            async with http.get(url, headers={"Authorization": shown}) as response:
                assert response.status == status


async def test_what_is_no_text_is_no_token() -> None:
    async with serving_metrics("127.0.0.1", 0, write, "s" * 16) as url:
        reader, writer = await asyncio.open_connection("127.0.0.1", urlsplit(url).port)
        writer.write(b"GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\nAuthorization: Bearer \xff\r\n\r\n")
        assert (await reader.read()).startswith(b"HTTP/1.1 401 ")
        writer.close()


@pytest.mark.parametrize("said", [b"", b"GET /metrics HTTP/1.1\r\nHost: x\r\n\r\nGET /me"])
async def test_a_connection_without_request_header_is_cut(monkeypatch: pytest.MonkeyPatch, said: bytes) -> None:
    monkeypatch.setattr(header_timeout, "HEAD_TIMEOUT", 0.05)
    reasons: list[str] = []
    async with serving_metrics("127.0.0.1", 0, write, turned_away=reasons.append) as url:
        reader, writer = await asyncio.open_connection("127.0.0.1", urlsplit(url).port)
        writer.write(said)
        with suppress(ConnectionResetError):
            await asyncio.wait_for(reader.read(), 10)
        writer.close()
    assert reasons == ["no request"]


async def test_so_many_wait_for_figures() -> None:
    may_write, reasons = asyncio.Event(), list[str]()

    async def write_later(accept: str) -> tuple[bytes, str]:
        await may_write.wait()
        return await write(accept)

    async def status(http: aiohttp.ClientSession, url: str) -> int:
        async with http.get(url) as response:
            return response.status

    async with (
        serving_metrics("127.0.0.1", 0, write_later, turned_away=reasons.append) as url,
        aiohttp.ClientSession() as http,
        asyncio.TaskGroup() as tasks,
    ):
        asked = [tasks.create_task(status(http, url)) for _ in range(MAX_SCRAPES + 1)]
        done, waiting = await asyncio.wait(asked, return_when=asyncio.FIRST_COMPLETED, timeout=10)
        assert ({task.result() for task in done}, reasons) == ({503}, ["full"])
        may_write.set()
        assert {await task for task in waiting} == {200}
