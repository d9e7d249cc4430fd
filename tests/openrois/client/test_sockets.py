"""A client over real sockets: how it dials, its errors without a gateway, and gateways that die and come back."""

import asyncio
import http
import json
import signal
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from openrois.client import Client, Connected, ConnectionFailed, Disconnected, ProfileChanged, Reconnect
from openrois.client.components import PersonDetection
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.transport import silence, websocket
from tests.support.demo import free_port
from tests.support.fleet import everything
from tests.support.grounds import Clock

pytestmark = pytest.mark.extra(name="gateway")

AT_ONCE = Reconnect(first=0.01, limit=0.05)


@pytest.mark.parametrize("given", ["", "127.0.0.1:8765", "ftp://127.0.0.1/", "ws://", "localhost"])
def test_what_is_no_address_is_refused_at_once(given: str) -> None:
    with pytest.raises(ValueError, match="is no address of a gateway, such as"):
        Client(given)


def test_a_password_does_not_belong_in_an_address() -> None:
    with pytest.raises(ValueError, match="give a token") as refusal:
        Client("ws://me:secret@127.0.0.1/")
    assert "secret" not in str(refusal.value)


async def test_no_gateway_there() -> None:
    port = free_port()
    with pytest.raises(ConnectionFailed, match=rf"no gateway answers at ws://127.0.0.1:{port}/; `openrois gateway` "):
        async with Client(f"ws://127.0.0.1:{port}"):
            pass


async def test_a_server_that_is_no_gateway() -> None:
    async def chat(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nhi")
        await writer.drain()
        writer.close()

    async with await asyncio.start_server(chat, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(ConnectionFailed, match=f"127.0.0.1:{port}/ answered 200: hi"):
            async with Client(f"ws://127.0.0.1:{port}"):
                pass


async def test_a_server_of_another_protocol() -> None:
    async def chat(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"220 mail.example ESMTP\r\n")
        await writer.drain()
        writer.close()

    async with await asyncio.start_server(chat, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(ConnectionFailed, match=f"what answers at ws://127.0.0.1:{port}/ is no gateway"):
            async with Client(f"ws://127.0.0.1:{port}"):
                pass


async def test_a_server_that_accepts_and_stays_silent() -> None:
    async def keep_silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    async with await asyncio.start_server(keep_silent, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(ConnectionFailed, match=r"the gateway did not answer within 0.1 s"):
            async with Client(f"ws://127.0.0.1:{port}", connect_timeout=0.1):
                pass


@asynccontextmanager
async def answering(
    handle: Callable[[ServerConnection], Awaitable[None]], refuse: Callable[..., Any] | None = None
) -> AsyncIterator[str]:
    async with serve(handle, "127.0.0.1", 0, process_request=refuse) as server:
        yield f"ws://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}/"


async def hold(far: ServerConnection) -> None:
    await far.wait_closed()


async def test_a_token_travels_in_the_header_and_nowhere_else() -> None:
    seen: list[str | None] = []

    def look(connection: ServerConnection, request: Request) -> Response:
        seen.append(request.headers.get("Authorization"))
        return connection.respond(http.HTTPStatus.UNAUTHORIZED, "the token has ended\n")

    async with answering(hold, look) as url:
        with pytest.raises(ConnectionFailed, match="answered 401: the token has ended") as refusal:
            async with Client(url, token="top-secret"):
                pass
        with pytest.raises(ConnectionFailed):
            async with Client(url):
                pass
    assert seen == ["Bearer top-secret", None]
    assert refusal.value.final
    assert "top-secret" not in str(refusal.value)


async def test_a_token_that_the_environment_names_is_shown_unless_another_one_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[str | None] = []

    def look(connection: ServerConnection, request: Request) -> Response:
        seen.append(request.headers.get("Authorization"))
        return connection.respond(http.HTTPStatus.UNAUTHORIZED, "no\n")

    file = tmp_path / "token"
    monkeypatch.setenv("OPENROIS_TOKEN_FILE", str(file))
    async with answering(hold, look) as url:
        # It is read whenever it is needed.
        for content, given in (("first\n", None), ("second\n", None), ("second\n", "own")):
            file.write_text(content)
            with pytest.raises(ConnectionFailed, match="answered 401"):
                await Client(url, token=given).connect()
        file.unlink()
        with pytest.raises(ConnectionFailed, match="the token cannot be read from"):
            await Client(url).connect()
    assert seen == ["Bearer first", "Bearer second", "Bearer own"]


async def test_a_gateway_that_answers_no_greeting() -> None:
    async with answering(hold) as url:
        with pytest.raises(ConnectionFailed, match=r"did not answer within 0.1 s"):
            async with Client(url, connect_timeout=0.1):
                pass


@asynccontextmanager
async def gateway_at(port: int) -> AsyncIterator[Any]:
    """Run a gateway with a robot at a port that another had before."""
    robot = everything("robot")
    async with run_gateway(GatewaySettings(port=port)) as gateway:
        await gateway.engine.attach(robot.registry)
        yield robot


async def test_a_gateway_that_restarts(clock: Clock) -> None:
    port = free_port()
    async with AsyncExitStack() as stack:
        first = await stack.enter_async_context(AsyncExitStack())
        await first.enter_async_context(gateway_at(port))
        client = await stack.enter_async_context(Client(f"ws://127.0.0.1:{port}", reconnect=clock.reconnect()))
        notices = client.notices(Connected, Disconnected)
        detected = await stack.enter_async_context((await client.find(PersonDetection)).person_detected())
        await client.bind("robot/navigation")
        await first.aclose()
        assert await anext(notices) == Disconnected("closed with 1001 the gateway stops", 0.5)
        await clock.pass_time()
        told = await anext(notices)
        assert isinstance(told, Disconnected)
        assert told.reason.startswith(f"no gateway answers at ws://127.0.0.1:{port}/")
        robot = await stack.enter_async_context(gateway_at(port))
        await clock.pass_time()
        assert await anext(notices) == Connected()
        while not detected.active:
            await client.search()
        robot.parts["PersonDetection"].tell("person_detected", number=4)
        assert (await anext(detected)).number == 4
        await client.component("robot/navigation").command("start")


@pytest.mark.parametrize(("code", "reason"), [(1012, "retry_after=0.01"), (1013, ""), (1011, "internal error")])
async def test_a_gateway_that_says_goodbye(code: int, reason: str) -> None:
    left = False

    async def leave_once(far: ServerConnection) -> None:
        nonlocal left
        with suppress(ConnectionClosed):
            while True:
                request = json.loads(await far.recv())
                result = {"return_code": "OK"}
                await far.send(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}))
                if request["method"] == "openrois.hello" and not left:
                    left = True
                    await far.close(code, reason)

    async with answering(leave_once) as url, Client(url, reconnect=AT_ONCE) as client:
        notices = client.notices()
        told = await anext(notices)
        assert isinstance(told, Disconnected)
        assert told.reason == f"closed with {code} {reason}".rstrip()
        assert await anext(notices) == Connected()


@asynccontextmanager
async def cable(port: int) -> AsyncIterator[tuple[int, asyncio.Event]]:
    """Forward to a port, until the event is set: then nothing passes, and neither side notices."""
    pulled = asyncio.Event()
    ends: list[asyncio.StreamWriter] = []
    forwarding: list[asyncio.Task[None]] = []

    async def forward(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while data := await reader.read(65536):
            if not pulled.is_set():
                writer.write(data)

    async def plug_in(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        far_reader, far_writer = await asyncio.open_connection("127.0.0.1", port)
        ends.extend((writer, far_writer))
        forwarding.append(asyncio.create_task(forward(reader, far_writer)))
        forwarding.append(asyncio.create_task(forward(far_reader, writer)))

    async with await asyncio.start_server(plug_in, "127.0.0.1", 0) as server:
        yield server.sockets[0].getsockname()[1], pulled
        for task in forwarding:
            task.cancel()
        for end in ends:
            end.transport.abort()
        await asyncio.gather(*forwarding, return_exceptions=True)


async def test_a_pulled_cable_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket, "_PING_INTERVAL", 0.05)
    monkeypatch.setattr(websocket, "_PING_TIMEOUT", 0.05)
    # The gateway is in this process too, and stands still with it where the machine is busy.
    monkeypatch.setattr(silence, "STOOD_STILL", 0.02)
    port = free_port()
    async with (
        gateway_at(port),
        cable(port) as (through, pulled),
        Client(f"ws://127.0.0.1:{through}", reconnect=AT_ONCE) as client,
    ):
        notices = client.notices(Disconnected, Connected)
        pulled.set()
        told = await anext(notices)
        assert isinstance(told, Disconnected)
        assert "1011" in told.reason or "1006" in told.reason
        # The next connection is not to be lost when this process stands still for a moment.
        monkeypatch.undo()
        pulled.clear()
        while not isinstance(await anext(notices), Connected):
            pass
        assert len(await client.search()) == 17


@asynccontextmanager
async def gateway_process(port: int) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run `openrois gateway` until the block ends."""
    openrois = Path(sys.executable).with_name("openrois")
    process = await asyncio.create_subprocess_exec(
        openrois, "gateway", "--port", str(port), stdout=asyncio.subprocess.PIPE
    )
    assert process.stdout is not None
    try:
        assert (await process.stdout.readline()).startswith(b"listening")
        yield process
    finally:
        with suppress(ProcessLookupError):
            process.terminate()
        await process.communicate()


@pytest.mark.long
async def test_a_gateway_that_is_killed_and_started_again() -> None:
    port = free_port()
    async with AsyncExitStack() as stack:
        async with gateway_process(port) as process:
            client = await stack.enter_async_context(Client(f"http://127.0.0.1:{port}/", reconnect=AT_ONCE))
            notices = client.notices(Disconnected, Connected, ProfileChanged)
            process.send_signal(signal.SIGKILL)
            told = await anext(notices)
            assert isinstance(told, Disconnected)
        searching = asyncio.ensure_future(client.search())
        await stack.enter_async_context(gateway_process(port))
        assert await searching == ()
        while not isinstance(await anext(notices), Connected):
            pass
