"""A gateway of a cluster as a process of its own: `python -m tests.support.nats_child URL PREFIX ID`.

It says what it receives and how each stream ends, a line each, and sends each message back.
"""

import asyncio
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from typing import Any

from openrois.cluster.link import NatsLink, NatsSettings, NatsStream
from openrois.transport.stream import StreamClosed
from tests.support.packages import ROOT

__all__ = ["gateway_process"]


@asynccontextmanager
async def gateway_process(url: str, prefix: str, gateway_id: str) -> AsyncIterator[asyncio.subprocess.Process]:
    """Run one while the block runs; it listens already."""
    words = ("-m", "tests.support.nats_child", url, prefix, gateway_id)
    process = await asyncio.create_subprocess_exec(sys.executable, *words, stdout=asyncio.subprocess.PIPE, cwd=ROOT)
    assert process.stdout is not None
    try:
        assert await process.stdout.readline() == b"listens\n"
        yield process
    finally:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _echo(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
    try:
        while True:
            text = await stream.receive()
            print(text[:40], flush=True)
            await stream.send(text)
    except StreamClosed as closed:
        print("ended", closed.code, flush=True)


async def _main(url: str, prefix: str, gateway_id: str) -> None:
    async with NatsLink(NatsSettings((url,), prefix=prefix), gateway_id) as link:
        await link.listen(_echo)
        print("listens", flush=True)
        await asyncio.Event().wait()


if __name__ == "__main__":
    asyncio.run(_main(*sys.argv[1:]))
