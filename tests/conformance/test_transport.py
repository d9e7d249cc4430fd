"""HTTP and WebSocket: admission, what a connection may carry, and how it ends for the one that is at fault."""

import asyncio
import json
import random
import socket
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from typing import Any
from urllib.parse import urlsplit

import pytest
from aiohttp import ClientSession
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from openrois.gateway import page
from openrois.gateway.server import Gateway
from openrois.gateway.socket import APPLICATION, SocketProfile
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot

KIB = 1024


async def ended(app: Application) -> int:
    """Wait until the gateway has ended the connection and return the close code."""
    async with deployment.patience():
        await app.socket.wait_closed()
    return app.socket.close_code or 0


def padded(size: int) -> str:
    """Return a request of exactly `size` bytes."""
    request = '{"jsonrpc":"2.0","id":1,"method":"rois.system.connect"}'
    return request + " " * (size - len(request))


class TestMessages:
    async def test_the_limit_is_exact(self, app: Application, other: Application) -> None:
        await app.send(padded(64 * KIB))
        assert (await app.answer(1))["result"] == {"return_code": "OK"}
        await app.send(padded(64 * KIB + 1))
        assert await ended(app) == 1009
        assert await other.code("rois.system.connect") == "OK"

    async def test_ten_megabytes_cost_one_connection(self, app: Application, other: Application) -> None:
        with suppress(ConnectionClosed):
            await app.send(padded(10 * KIB * KIB))
        assert await ended(app) == 1009
        assert await other.code("rois.query.query", query_type="brightness") == "OK"

    async def test_an_adapter_may_say_more(self, gateway: Gateway, robot: Robot, other: Application) -> None:
        async with connect(gateway.url.replace("http", "ws") + "adapter") as near:
            await near.recv()
            await near.send(" " * (KIB * KIB))
            assert json.loads(await near.recv())["error"]["code"] == -32700
            await near.send(" " * (KIB * KIB + 1))
            async with deployment.patience():
                await near.wait_closed()
            assert near.close_code == 1009
        assert await other.code("rois.system.connect") == "OK"

    async def test_binary_frames_are_refused(self, app: Application, gateway: Gateway) -> None:
        await app.socket.send(b"{}")
        assert await ended(app) == 1003
        async with connect(gateway.url.replace("http", "ws") + "adapter") as near:
            await near.send(b"{}")
            async with deployment.patience():
                await near.wait_closed()
            assert near.close_code == 1003

    async def test_compression_is_not_negotiated(self, app: Application) -> None:
        assert app.socket.response is not None
        assert "Sec-WebSocket-Extensions" not in app.socket.response.headers


class TestWhoIsLetIn:
    async def test_pages_of_this_machine_only(self, gateway: Gateway, subtests: pytest.Subtests) -> None:
        port = gateway.url.rsplit(":", 1)[1].rstrip("/")
        for origin, status in [
            (None, 101),
            ("http://localhost:5173", 101),
            (f"http://127.0.0.1:{port}", 101),
            ("http://[::1]:80", 101),
            ("https://127.0.0.2", 101),
            ("null", 403),
            ("", 403),
            ("http://evil.example", 403),
            ("http://localhost.evil.example", 403),
            ("http://evil.example#localhost", 403),
            ("http://localhost@evil.example", 403),
            ("http://127.0.0.1.evil.example", 403),
            ("http://[", 403),
            ("http://10.0.0.1", 403),
            ("file://", 403),
        ]:
            for path in ("", "adapter"):
                with subtests.test(f"{origin} /{path}"):
                    assert await upgraded(gateway, path, origin=origin) == status

    async def test_by_a_name_of_this_machine_only(self, gateway: Gateway, subtests: pytest.Subtests) -> None:
        for host, status in [
            ("localhost", 200),
            ("LOCALHOST:1", 200),
            ("127.0.0.1:8765", 200),
            ("127.9.9.9", 200),
            ("[::1]:8765", 200),
            ("evil.example", 403),
            ("localhost.evil.example", 403),
            ("127.0.0.1.evil.example", 403),
            ("192.168.0.1", 403),
            ("[", 403),
            ("", 403),
        ]:
            with subtests.test(host):
                async with (
                    ClientSession() as http,
                    http.get(gateway.url + "healthz", headers={"Host": host}) as answer,
                ):
                    assert answer.status == status

    async def test_only_so_many_at_a_time(self) -> None:
        async with (
            deployment.gateway(most_applications=2) as gateway,
            deployment.application(gateway) as first,
            deployment.application(gateway),
        ):
            assert await upgraded(gateway, "") == 503
            assert await first.code("rois.system.connect") == "OK"


async def upgraded(gateway: Gateway, path: str, origin: str | None = None) -> int:
    """Try to open a WebSocket and return the status of the answer."""
    try:
        url = gateway.url.replace("http", "ws") + path
        headers = {} if origin is None else {"Origin": origin}
        async with connect(url, additional_headers=headers) as opened:
            return opened.response.status_code if opened.response is not None else 0
    except InvalidStatus as refused:
        return refused.response.status_code


class TestPages:
    async def test_healthz(self, gateway: Gateway, adapter: Adapter) -> None:
        """It shows only that the gateway lives, and nothing of what is behind it."""
        assert await get(gateway, "healthz") == (200, '{"status": "ok"}')
        assert await get(gateway, "readyz") == (200, '{"status": "ready"}')

    async def test_a_page_that_was_not_built_says_what_to_do(
        self, gateway: Gateway, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for folder in (tmp_path, tmp_path / "missing"):
            monkeypatch.setattr(page, "static_files", lambda folder=folder: folder)
            for path in ("", "main.js"):
                status, body = await get(gateway, path)
                assert (status, "make page" in body) == (503, True)

    async def test_the_page_and_its_files_and_nothing_else(
        self, gateway: Gateway, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        built = tmp_path / "static"
        (built / "below").mkdir(parents=True)
        (tmp_path / "secret.txt").write_text("secret")
        (built / "below" / "x.txt").write_text("below")
        (built / "index.html").write_text("<p>日本</p>")
        (built / "main.js").write_text("1")
        (built / "font.woff2").write_bytes(b"\0")
        monkeypatch.setattr(page, "static_files", lambda: built)
        async with ClientSession() as http:
            async with http.get(gateway.url) as answer:
                assert (answer.status, answer.content_type, answer.charset) == (200, "text/html", "utf-8")
                assert await answer.text() == "<p>日本</p>"
                assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
                assert answer.headers["X-Content-Type-Options"] == "nosniff"
            async with http.get(gateway.url + "main.js") as answer:
                assert (answer.content_type, answer.charset) == ("text/javascript", "utf-8")
            async with http.get(gateway.url + "font.woff2") as answer:
                assert (answer.content_type, answer.charset) == ("font/woff2", None)
            async with http.post(gateway.url) as answer:
                assert answer.status == 405
        for path in ("nothing", "../secret.txt", "%2e%2e/secret.txt", "below/x.txt", "below", "..%2fsecret.txt"):
            assert (await get(gateway, path))[0] == 404

    async def test_the_adapter_path_is_for_websockets(self, gateway: Gateway) -> None:
        assert (await get(gateway, "adapter"))[0] == 426


async def get(gateway: Gateway, path: str) -> tuple[int, str]:
    """Return status and body of one plain request, its path as written."""
    host, _, port = gateway.url.removeprefix("http://").rstrip("/").partition(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    writer.write(f"GET /{path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
    async with deployment.patience():
        head, _, body = (await reader.read()).decode().partition("\r\n\r\n")
    writer.close()
    await writer.wait_closed()
    return int(head.split()[1]), body


@asynccontextmanager
async def deaf(gateway: Gateway, path: str = "") -> AsyncIterator[socket.socket]:
    """Open a WebSocket that takes next to nothing in and is never read from."""
    host, _, port = gateway.url.removeprefix("http://").rstrip("/").partition(":")
    loop = asyncio.get_running_loop()
    with socket.socket() as near:
        near.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        near.setblocking(False)
        await loop.sock_connect(near, (host, int(port)))
        upgrade = (
            f"GET /{path} HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        await loop.sock_sendall(near, upgrade.encode())
        async with deployment.patience():
            assert (await loop.sock_recv(near, 12)).startswith(b"HTTP/1.1 101")
        yield near


def frame(text: str) -> bytes:
    """Return a masked text frame with a mask of zeros."""
    data = text.encode()
    length = bytes([0x80 | len(data)]) if len(data) < 126 else bytes([0x80 | 126]) + len(data).to_bytes(2, "big")
    return b"\x81" + length + bytes(4) + data


async def cut(near: socket.socket) -> None:
    """Send until the gateway has cut the connection."""
    request = '{"jsonrpc":"2.0","id":"%s","method":"rois.system.connect"}'
    loop = asyncio.get_running_loop()
    with suppress(OSError):
        async with asyncio.timeout(60):
            # Long ids come back in long answers, which fill what the kernel keeps; then many answers fill the outbox.
            for _ in range(100):
                await loop.sock_sendall(near, frame(request % ("x" * 60_000)))
            while True:
                await loop.sock_sendall(near, frame(request % "x") * 100)


class TestWhoDoesNotRead:
    async def test_is_cut_off_and_costs_no_other_anything(self, gateway: Gateway, app: Application) -> None:
        async with deaf(gateway) as near:
            cutting = asyncio.ensure_future(cut(near))
            while not cutting.done():
                assert await app.code("rois.query.query", query_type="brightness") == "OK"
            await cutting

    async def test_loses_events_and_delays_no_other(self, gateway: Gateway, app: Application, robot: Robot) -> None:
        async with deaf(gateway) as near:
            subscribe = '{"jsonrpc":"2.0","id":1,"method":"rois.event.subscribe","params":{"event_type":"rang"}}'
            await asyncio.get_running_loop().sock_sendall(near, frame(subscribe))
            await app.ask("rois.event.subscribe", event_type="rang")
            for _ in range(200):
                robot.bell.ring("x" * 10_000)
                assert await app.next("rois.event.notify_event")
            assert await app.code("rois.system.connect") == "OK"

    async def test_does_not_keep_the_gateway_from_stopping(self) -> None:
        async with asyncio.timeout(60):
            async with deployment.gateway() as gateway, deaf(gateway) as near:
                request = frame('{"jsonrpc":"2.0","id":1,"method":"rois.system.get_profile"}')
                await asyncio.get_running_loop().sock_sendall(near, request * 200)
                async with deployment.application(gateway) as app:
                    await app.settled()


async def until_cut(near: socket.socket) -> None:
    """Read until the gateway has cut the connection."""
    with suppress(ConnectionResetError):
        while await asyncio.get_running_loop().sock_recv(near, 4096):
            pass


QUICK = SocketProfile(max_message=64 * KIB, ping_interval=0.02, ping_timeout=0.1)
FORBEARING = SocketProfile(max_message=64 * KIB, ping_interval=0.02, ping_timeout=5)


class TestPings:
    async def test_a_silent_side_is_cut(self, subtests: pytest.Subtests) -> None:
        for path in ("", "adapter"):
            with subtests.test(path):
                async with (
                    deployment.gateway(application=QUICK, adapter=QUICK) as gateway,
                    deaf(gateway, path) as near,
                    deployment.patience(),
                ):
                    await until_cut(near)

    async def test_one_that_answers_stays(self) -> None:
        async with deployment.gateway(application=FORBEARING) as gateway, deaf(gateway) as near:
            loop = asyncio.get_running_loop()
            async with deployment.patience():
                head = b""
                while not head.endswith(b"\r\n\r\n"):
                    # One by one: the first ping may stand behind it already.
                    head += await loop.sock_recv(near, 1)
                for _ in range(5):
                    assert await loop.sock_recv(near, 2) == b"\x89\x10"
                    asked = b""
                    while len(asked) < 16:
                        asked += await loop.sock_recv(near, 16 - len(asked))
                    await loop.sock_sendall(near, b"\x8a\x90" + bytes(4) + asked)

    async def test_one_whose_answers_wait_behind_its_own_requests_stays(
        self, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("openrois.jsonrpc.request_queue.MAX_RUNNING_REQUESTS", 2)
        # The application is in this process too, and stands still with it where the machine is busy.
        monkeypatch.setattr("openrois.transport.silence.STOOD_STILL", 0.02)
        async with (
            deployment.gateway(application=QUICK) as gateway,
            deployment.adapter(gateway, *robot.parts()),
            deployment.application(gateway) as app,
        ):
            robot.door.may_answer.clear()
            waiting = [await app.begin("rois.query.query", query_type="view") for _ in range(3)]
            loop = asyncio.get_running_loop()
            passed = loop.create_future()
            loop.call_later(3 * QUICK.ping_timeout, passed.set_result, None)
            await passed
            robot.door.may_answer.set()
            for request_id in waiting:
                assert (await app.answer(request_id))["result"]["return_code"] == "OK"


async def test_the_default_bounds() -> None:
    assert (APPLICATION.max_message, APPLICATION.ping_interval, APPLICATION.ping_timeout) == (64 * KIB, 4, 5)


@pytest.mark.parametrize("seed", range(20))
async def test_a_client_that_leaves_during_the_handshake_leaves_no_trace(
    gateway: Gateway, app: Application, caplog: pytest.LogCaptureFixture, seed: int
) -> None:
    chance = random.Random(seed)
    loop = asyncio.get_running_loop()
    url = urlsplit(gateway.url)
    upgrade = (
        f"GET /{chance.choice(['', 'adapter'])} HTTP/1.1\r\nHost: {url.netloc}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
    )
    pings = b"\x89\x80" + bytes(4)
    said = upgrade.encode() + pings * chance.randrange(40)
    for _ in range(4):
        with socket.socket() as near:
            near.setblocking(False)
            near.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            await loop.sock_connect(near, (url.hostname, url.port))
            await loop.sock_sendall(near, said[: chance.randint(1, len(said))])
            for _ in range(chance.randrange(4)):
                await asyncio.sleep(0)
    await app.settled()
    assert not [record for record in caplog.records if record.exc_info]
