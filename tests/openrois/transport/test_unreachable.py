"""Why a gateway is not reached, as people read it; what is dialled is real."""

import asyncio
import http
import socket
import ssl
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import InvalidHandshake
from websockets.http11 import Request, Response

from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.unreachable import unreachable
from openrois.transport.websocket import dial
from tests.support.certificates import Authority


async def said_of(url: str, credentials: Credentials = NO_CREDENTIALS, patience: float = 60.0) -> str:
    with pytest.raises((OSError, ValueError, InvalidHandshake)) as raised:
        async with dial(url, credentials=credentials, open_timeout=patience):
            pass
    return unreachable(url, raised.value, remedies=("ask the porter", "ask a notary"))


async def hold(far: ServerConnection) -> None:
    await far.wait_closed()


def address(server: Any, scheme: str = "ws") -> str:
    return f"{scheme}://127.0.0.1:{next(iter(server.sockets)).getsockname()[1]}/"


async def test_no_gateway_listens() -> None:
    async with serve(hold, "127.0.0.1", 0) as server:
        url = address(server)
    assert (await said_of(url)).startswith(f"no gateway answers at {url}; `openrois gateway` starts one here (")


@pytest.mark.parametrize(
    ("status", "said"),
    [(401, "answered 401: not without a token (ask the porter)"), (403, "answered 403: not without a token")],
)
async def test_a_refusal(status: int, said: str) -> None:
    def refuse(connection: ServerConnection, _request: Request) -> Response:
        return connection.respond(http.HTTPStatus(status), "not without\n\x1b a token\n")

    async with serve(hold, "127.0.0.1", 0, process_request=refuse) as server:
        assert await said_of(address(server)) == f"{address(server)} {said}"


@pytest.mark.parametrize(
    ("scheme", "said"),
    [("ws", "what answers at {url} is no gateway (or one with TLS: wss://): "), ("wss", "no TLS is spoken at {url}; ")],
)
async def test_something_else_answers(scheme: str, said: str) -> None:
    hung_up = asyncio.Event()

    async def curt(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"220 mail.example ESMTP\r\n")
        writer.close()
        await writer.wait_closed()
        hung_up.set()

    async with await asyncio.start_server(curt, "127.0.0.1", 0) as server:
        url = address(server, scheme)
        assert (await said_of(url)).startswith(said.format(url=url))
        await hung_up.wait()


async def test_nothing_answers() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        url = f"ws://127.0.0.1:{silent.getsockname()[1]}/"
        assert await said_of(url, patience=0.01) == f"nothing answers at {url} in time"


async def test_a_certificate_of_an_unknown_authority(tmp_path: Path) -> None:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*Authority(tmp_path).issue())
    async with serve(hold, "127.0.0.1", 0, ssl=context) as server:
        said = await said_of(address(server, "wss"))
    assert said.endswith("its certificate is not trusted: unable to get local issuer certificate (ask a notary)")


async def test_a_certificate_for_another_name(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*authority.issue())
    async with serve(hold, "127.0.0.2", 0, ssl=context) as server:
        url = address(server, "wss").replace("127.0.0.1", "127.0.0.2")
        said = await said_of(url, Credentials(ca_file=authority.file))
    assert said.startswith(f"no gateway is reached at {url}: its certificate is not trusted: IP address mismatch")
    assert "notary" not in said


async def test_what_is_to_be_shown_cannot_be_had(tmp_path: Path) -> None:
    said = await said_of("ws://127.0.0.1:9/", Credentials.of_files(tmp_path / "token", None))
    assert said.startswith("ws://127.0.0.1:9/ is not dialled: the token cannot be read from ")
