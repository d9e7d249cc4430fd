"""A real NATS server on a loopback port, which can be killed, frozen and started again; and streams over it."""

import asyncio
import itertools
import json
import os
import signal
import socket
import subprocess
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from openrois.cluster import exchange, presence, pulse
from openrois.cluster.connection import NatsConnection
from openrois.cluster.frames import Accept, Frame, Kind, parse_frame, parse_said
from openrois.cluster.link import NatsLink, NatsSettings, NatsStream
from openrois.cluster.subjects import Subjects
from openrois.transport.stream import StreamClosed
from tests.support.demo import free_port
from tests.support.nats_program import nats_program

__all__ = [
    "NatsServer",
    "Stranger",
    "cluster_name",
    "dialled",
    "echo",
    "ended",
    "freeze",
    "links",
    "nats_server",
    "patient_links",
    "settings",
    "stand_in",
]

PATIENCE = 30.0
"""Seconds that a server may take on a busy machine to begin."""

_clusters = itertools.count()


def freeze(pid: int) -> None:
    """Stop a child process, and wait until all its threads stand."""
    os.kill(pid, signal.SIGSTOP)
    os.waitid(os.P_PID, pid, os.WSTOPPED | os.WNOWAIT)


class NatsServer:
    """The server's process.

    Attributes:
        port: where it listens, also after it was started again.
        url: its address.
    """

    def __init__(self, folder: Path, configuration: str = "", scheme: str = "nats") -> None:
        self.port = free_port()
        self.url = f"{scheme}://127.0.0.1:{self.port}"
        self._process: subprocess.Popen[bytes] | None = None
        self._file = folder / f"nats-{self.port}.conf"
        self._file.write_text(f'host: "127.0.0.1"\nport: {self.port}\n{configuration}\n')

    def start(self) -> None:
        """Start it, and wait until it listens: that takes less time than a heartbeat."""
        program = nats_program()
        assert program is not None
        quiet = subprocess.DEVNULL
        self._process = subprocess.Popen([program, "-c", self._file], stdin=quiet, stdout=quiet, stderr=quiet)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.005)
        raise TimeoutError("the NATS server does not listen")

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def freeze(self) -> None:
        assert self._process is not None
        freeze(self._process.pid)

    def thaw(self) -> None:
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)


@contextmanager
def nats_server(folder: Path, configuration: str = "", scheme: str = "nats") -> Iterator[NatsServer]:
    """Run one while the block runs."""
    server = NatsServer(folder, configuration, scheme)
    try:
        server.start()
        yield server
    finally:
        server.kill()


@asynccontextmanager
async def stand_in(talk: Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]) -> AsyncIterator[str]:
    """Serve connections as a test wants, on a port that is yielded as `127.0.0.1:port`; wait until they are closed."""
    serving: set[asyncio.Task[None]] = set()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.current_task()
        assert task is not None
        serving.add(task)
        try:
            await talk(reader, writer)
        finally:
            writer.close()
            with suppress(OSError):
                await writer.wait_closed()

    async with await asyncio.start_server(serve, "127.0.0.1", 0) as server:
        yield f"127.0.0.1:{server.sockets[0].getsockname()[1]}"
        if serving:
            await asyncio.wait(serving)


@contextmanager
def patient_links() -> Iterator[None]:
    """Let gateways wait for each other as long as a busy machine needs, where silence is not what a test is about."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (presence, pulse):
            patch.setattr(module, "SILENCE", PATIENCE)
        patch.setattr(exchange, "DIAL_TIMEOUT", PATIENCE)
        yield


def cluster_name() -> str:
    """Return a prefix that no other test has."""
    return f"test-{next(_clusters)}"


def settings(url: str, prefix: str = "", **more: Any) -> NatsSettings:
    """Return settings for a cluster of its own, or for that of `prefix`."""
    return NatsSettings((url,), prefix=prefix or cluster_name(), **more)


@asynccontextmanager
async def links(*urls: str, prefix: str = "", **more: Any) -> AsyncIterator[list[NatsLink]]:
    """Enter links `a`, `b`, ... of one cluster, each by its own way to NATS."""
    prefix = prefix or cluster_name()
    async with AsyncExitStack() as stack:
        yield [
            await stack.enter_async_context(NatsLink(settings(url, prefix), name, **more))
            for name, url in zip("abcdefgh", urls, strict=False)
        ]


@asynccontextmanager
async def dialled(near: NatsLink, far: NatsLink) -> AsyncIterator[Callable[[], Any]]:
    """Yield a function that returns both ends of a new stream from one gateway to another."""
    accepted: asyncio.Queue[NatsStream] = asyncio.Queue()
    over = asyncio.Event()

    async def accept(stream: NatsStream, _hello: Any) -> None:
        stream.accept()
        await accepted.put(stream)
        await over.wait()

    async def pair() -> tuple[NatsStream, NatsStream]:
        return await near.dial(far.gateway_id, {}), await accepted.get()

    await far.listen(accept)
    try:
        yield pair
    finally:
        over.set()


async def echo(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
    """Send each message back, as a gateway's handler."""
    while True:
        await stream.send(await stream.receive())


async def ended(stream: NatsStream) -> StreamClosed:
    """Return the end of a stream, behind all that comes before it."""
    try:
        while True:
            await asyncio.wait_for(stream.receive(), PATIENCE)
    except StreamClosed as closed:
        return closed


class Stranger:
    """A program at NATS that says whatever a test wants where a gateway would speak.

    Attributes:
        prefix: of the cluster's subjects.
        came: what was published to its streams, newest last.
    """

    def __init__(self, connection: NatsConnection, prefix: str) -> None:
        self.prefix = prefix
        self._connection = connection
        self._subjects = subjects = Subjects(prefix)
        self.came: asyncio.Queue[bytes] = asyncio.Queue()
        connection.subscribe(subjects.streams(self.LINK), lambda _subject, _headers, data: self.came.put_nowait(data))

    LINK = "0123456789abcdef"

    @classmethod
    @asynccontextmanager
    async def entered(cls, url: str, prefix: str) -> "AsyncIterator[Stranger]":
        """Connect one while the block runs."""
        connection = await NatsConnection.open(settings(url, prefix), url, "stranger")
        try:
            stranger = cls(connection, prefix)
            await connection.flush()
            yield stranger
        finally:
            connection.abort("over")

    def say(self, subject: str, data: bytes) -> None:
        self._connection.publish(subject, data)

    def dial(self, gateway_id: str, **more: Any) -> None:
        """Dial a gateway, with its own stream 0."""
        said = {"link": self.LINK, "stream": 0, "window": 1 << 20, "gateway": "stranger", "hello": {}, **more}
        self.say(self._subjects.dial(gateway_id), json.dumps(said).encode())

    async def frame(self) -> Frame:
        """Return the next frame that is no sign of life."""
        while True:
            frame = parse_frame(await asyncio.wait_for(self.came.get(), PATIENCE))
            if frame.kind is not Kind.ALIVE:
                return frame

    async def accepted(self) -> str:
        """Return where to send frames to, when the gateway has accepted."""
        frame = await self.frame()
        assert (frame.kind, frame.number) == (Kind.ACCEPT, 0)
        accept = parse_said(Accept, frame.body)
        return self._subjects.stream(accept.link, accept.stream)
