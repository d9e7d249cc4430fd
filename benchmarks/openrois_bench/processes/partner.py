"""Processes of a bench that are asked by JSON-RPC, a message a line, through pipes."""

import asyncio
import resource
import sys
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Final

import uvloop
from openrois_body.processes.child import Output, child_process
from openrois_streaming.clock import SystemClock

from openrois.jsonrpc.session import Handler, RpcError, RpcSession, SessionClosed
from openrois.transport.stream import StreamClosed
from openrois_bench.errors import BenchFailed

__all__ = ["SWITCH_INTERVAL", "Partner", "PipeStream", "cpu_seconds", "partner", "serve"]

MAX_MESSAGE: Final = 4 << 20
"""Bytes of one message: the latencies of an hour of pictures fit."""

_CHUNK: Final = 65536
SWITCH_INTERVAL: Final = 0.0005
"""As in the avatar adapter: encoder threads must not keep the event loop waiting for 5 ms."""


class PipeStream:
    """Two pipes as a `MessageStream`."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer
        self._rest = b""

    async def receive(self) -> str:
        """Wait for the next line."""
        pieces = [self._rest]
        while b"\n" not in pieces[-1]:
            piece = await self._reader.read(_CHUNK)
            if not piece:
                raise StreamClosed(1006, "the other process has ended")
            pieces.append(piece)
            if sum(map(len, pieces)) > MAX_MESSAGE:
                raise StreamClosed(1009, "too long a line")
        line, _, self._rest = b"".join(pieces).partition(b"\n")
        return line.decode()

    async def send(self, text: str) -> None:
        """Write one line; waits while the pipe is full."""
        try:
            self._writer.write(text.encode() + b"\n")
            await self._writer.drain()
        except OSError as error:
            raise StreamClosed(1006, str(error)) from error

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close the pipe that is written to; the other process reads that this one has ended."""
        self._writer.close()

    def abort(self) -> None:
        """Close it without what still waits."""
        self._writer.transport.abort()


class Partner:
    """A child that takes part."""

    def __init__(self, name: str, session: RpcSession, output: Output) -> None:
        self._name = name
        self._session = session
        self._output = output

    async def ask(self, name: str, params: Mapping[str, Any], *, within: float) -> Any:
        """Have it do something, and return its result.

        Raises:
            BenchFailed: it could not, it has ended, or it took longer than `within` seconds.
        """
        try:
            return await self._session.call(name, params, timeout=within)
        except TimeoutError as error:
            raise BenchFailed(f"{self._name}: {name} took longer than {within:.0f} s") from error
        except (RpcError, SessionClosed) as error:
            # Its words come through another pipe than its answers.
            await asyncio.sleep(0.1)
            raise BenchFailed(f"{self._name}: {name}: {error}: {self._output.last_words}") from error


@asynccontextmanager
async def partner(module: str, *arguments: str) -> AsyncIterator[Partner]:
    """Run `python -m module` for as long as the context lasts; it has to call `serve`."""
    output = Output(module, SystemClock())
    async with child_process(module, *arguments, output=output, conversation=True) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        session = RpcSession(PipeStream(process.stdout, process.stdin))
        running = asyncio.create_task(session.run(), name=f"conversation with {module}")
        try:
            yield Partner(module.rpartition(".")[2], session, output)
        finally:
            running.cancel()
            await asyncio.wait({running})


def cpu_seconds() -> float:
    """Return the CPU seconds that this process has used so far, in all its threads."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def serve(role: Callable[[], AbstractAsyncContextManager[Mapping[str, Handler]]]) -> None:
    """In a child: enter `role` and answer with its methods until the other end of the pipes is gone."""
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_serve(role))


async def _serve(role: Callable[[], AbstractAsyncContextManager[Mapping[str, Handler]]]) -> None:
    loop = asyncio.get_running_loop()
    reader = asyncio.StreamReader()
    await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    transport, protocol = await loop.connect_write_pipe(
        lambda: asyncio.StreamReaderProtocol(asyncio.StreamReader()), sys.stdout
    )
    writer = asyncio.StreamWriter(transport, protocol, None, loop)
    async with role() as methods:
        await RpcSession(PipeStream(reader, writer), methods).run()
