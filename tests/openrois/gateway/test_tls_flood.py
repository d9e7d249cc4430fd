"""Half handshakes of TLS at a gateway that may open few files, and what they cost genuine clients."""

import asyncio
import resource
import socket
import ssl
from contextlib import AsyncExitStack, suppress
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
import psutil

from tests.support import deployment
from tests.support.certificates import Authority
from tests.support.ground import gateway_program
from tests.support.tokens import key_file

CLIENT_HELLO_BEGIN = bytes.fromhex("16030102000100")
"""The header of a record with a `ClientHello` of 512 bytes, and nothing of it."""

MOST_FILES = 256
HALF_HANDSHAKES = 600
GENUINE = 12


async def half_handshake(stack: AsyncExitStack, port: int, number: int) -> None:
    """Begin a handshake from one of four addresses, and let it stand until the stack unwinds."""
    near = stack.enter_context(socket.socket())
    near.setblocking(False)
    near.bind((f"127.0.0.{1 + number % 4}", 0))
    with suppress(ConnectionError):
        await asyncio.get_running_loop().sock_connect(near, ("127.0.0.1", port))
        near.send(CLIENT_HELLO_BEGIN)


async def served(url: str, trusting: ssl.SSLContext) -> None:
    """Come in as clients do that try again, each time with a connection of its own."""
    while True:
        with suppress(aiohttp.ClientError, ConnectionError):
            async with aiohttp.ClientSession() as http, http.get(f"{url}healthz", ssl=trusting) as answer:
                assert answer.status == 200
                return


async def test_half_handshakes_leave_files_and_time_to_genuine_clients(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    cert, key = authority.issue()
    options = ("--port", "0", "--auth-key", str(key_file(tmp_path)), "--tls-cert", str(cert), "--tls-key", str(key))

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (MOST_FILES, MOST_FILES))

    log = tmp_path / "gateway.log"
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(gateway_program(*options, log=log, preexec_fn=limited))
        url = gateway.first.removeprefix("listening ")
        process = psutil.Process(gateway.process.pid)
        before, most = process.num_fds(), 0
        async with deployment.patience(), asyncio.TaskGroup() as tasks:
            for number in range(HALF_HANDSHAKES):
                tasks.create_task(half_handshake(stack, urlsplit(url).port or 0, number))
                if number % (HALF_HANDSHAKES // GENUINE) == 0:
                    tasks.create_task(served(url, authority.context()))
                    most = max(most, process.num_fds())
                await asyncio.sleep(0)
        most = max(most, process.num_fds())
        # A quarter of the files may be silent connections; some that were cut are being closed.
        assert before < most <= before + MOST_FILES // 4 + 32 + GENUINE
    assert "could not be accepted" not in log.read_text()
    assert "out of system resource" not in log.read_text()
