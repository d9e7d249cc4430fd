"""The floor of the machine, a process of its own: a raw TCP echo, and an echo by the bare `websockets` library."""

import argparse
import asyncio
import signal
import ssl
from collections.abc import Sequence
from typing import Any

import uvloop
from websockets.asyncio.server import ServerConnection, serve

__all__: list[str] = []


class _Echo(asyncio.Protocol):
    def connection_made(self, transport: Any) -> None:
        self._transport: asyncio.Transport = transport

    def data_received(self, data: bytes) -> None:
        self._transport.write(data)


async def _echo(connection: ServerConnection) -> None:
    async for message in connection:
        await connection.send(message)


async def _main(certificate: Sequence[str]) -> None:
    loop = asyncio.get_running_loop()
    stopped = asyncio.Event()
    loop.add_signal_handler(signal.SIGTERM, stopped.set)
    context = None
    if certificate:
        context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
        context.load_cert_chain(*certificate)
    tcp = await loop.create_server(_Echo, "127.0.0.1", 0)
    async with tcp, serve(_echo, "127.0.0.1", 0, compression=None, ssl=context) as server:
        print(tcp.sockets[0].getsockname()[1], next(iter(server.sockets)).getsockname()[1], flush=True)
        await stopped.wait()


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--uvloop", action="store_true")
    parser.add_argument("--certificate", nargs=2, default=())
    arguments = parser.parse_args()
    (uvloop if arguments.uvloop else asyncio).run(_main(arguments.certificate))
