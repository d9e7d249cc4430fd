import asyncio
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from openrois_bench.errors import BenchFailed
from openrois_bench.processes import partner as partner_module
from openrois_bench.processes.partner import PipeStream, partner

from openrois.jsonrpc.session import RpcSession
from openrois.transport.stream import StreamClosed


@asynccontextmanager
async def ends() -> AsyncIterator[tuple[asyncio.StreamWriter, PipeStream, asyncio.StreamReader]]:
    """A pipe stream over a socket, and the reader and writer at the other end of it."""
    accepted: asyncio.Queue[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = asyncio.Queue()
    server = await asyncio.start_server(lambda *pair: accepted.put_nowait(pair), "127.0.0.1", 0)
    reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
    far_reader, far_writer = await accepted.get()
    try:
        async with asyncio.timeout(60):
            yield far_writer, PipeStream(reader, writer), far_reader
    finally:
        for each in (writer, far_writer):
            each.close()
        server.close()


async def send_often(stream: PipeStream) -> None:
    """Send until the kernel has noticed the closed end."""
    for _ in range(100):
        await stream.send("x" * 10_000)


async def test_messages_are_lines_however_they_arrive() -> None:
    async with ends() as (far, stream, _):
        far.write(b'{"a": 1}\n{"b')
        assert await stream.receive() == '{"a": 1}'
        far.write('": "ü"}\n\n'.encode())
        assert await stream.receive() == '{"b": "ü"}'
        assert await stream.receive() == ""


async def test_a_message_is_sent_as_one_line() -> None:
    async with ends() as (_, stream, far):
        await stream.send('"ü"')
        assert await far.readline() == '"ü"\n'.encode()
        await stream.close()
        assert await far.read() == b""


async def test_the_end_of_the_other_process_ends_the_stream() -> None:
    async with ends() as (far, stream, _):
        far.write(b"half a mess")
        far.close()
        with pytest.raises(StreamClosed, match="has ended"):
            await stream.receive()


async def test_a_line_without_an_end_ends_the_stream(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(partner_module, "MAX_MESSAGE", 100)
    async with ends() as (far, stream, _):
        far.write(b"x" * 101)
        with pytest.raises(StreamClosed, match="too long"):
            await stream.receive()


async def test_write_after_close_ends_the_stream() -> None:
    async with ends() as (far, stream, _):
        far.transport.abort()
        await far.wait_closed()
        with pytest.raises(StreamClosed):
            await send_often(stream)


async def test_an_aborted_stream_says_nothing_more() -> None:
    async with ends() as (_, stream, far):
        stream.abort()
        assert await far.read() == b""


CHILD = """
import os
from contextlib import nullcontext
from openrois_bench.processes.partner import serve

async def double(params): return [params["of"]] * 2
async def fail(params): raise ValueError("it is too much")
async def die(params):
    print("farewell", flush=True, file=__import__("sys").stderr)
    os._exit(3)
async def wait(params): await __import__("asyncio").Event().wait()

if __name__ == "__main__":
    serve(lambda: nullcontext({"double": double, "fail": fail, "die": die, "wait": wait}))
"""


@pytest.fixture
def child(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    (tmp_path / "some_child.py").write_text(CHILD)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return "some_child"


@pytest.mark.engine
async def test_child_answers_and_its_failures_keep_their_words(child: str) -> None:
    async with asyncio.timeout(60), partner(child) as asked:
        assert await asked.ask("double", {"of": "x" * 200_000}, within=15) == ["x" * 200_000] * 2
        with pytest.raises(BenchFailed, match=r"some_child: fail: .*ValueError: it is too much"):
            await asked.ask("fail", {}, within=15)
        with pytest.raises(BenchFailed, match="some_child: wait took longer than 0 s"):
            await asked.ask("wait", {}, within=0.01)
        with pytest.raises(BenchFailed, match=r"some_child: die: .*farewell"):
            await asked.ask("die", {}, within=15)


@pytest.mark.engine
async def test_child_ends_with_its_parent(child: str) -> None:
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", child, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE
    )
    async with asyncio.timeout(60):
        assert process.stdin is not None
        assert process.stdout is not None
        session = RpcSession(PipeStream(process.stdout, process.stdin))
        running = asyncio.create_task(session.run())
        assert await session.call("double", {"of": 1}, timeout=15) == [1, 1]
        await session.close()
        assert await process.wait() == 0
        await running
