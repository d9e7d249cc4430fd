"""One run: a sender, and viewers in another namespace. Run by `__main__` inside the sender's namespace.

`python -m openrois_bench.streams.peers.sender KIND VIEWERS SECONDS NAMESPACE`; prints what was measured as a line of
JSON.
"""

import asyncio
import json
import os
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

import uvloop

from openrois_bench.processes.child import cpu_of
from openrois_bench.streams.fanout.encoded import Answering, Published, send_with_aiortc, send_with_ours
from openrois_bench.streams.peers.encoding import pictures, send_with_plain
from openrois_bench.streams.peers.feeding import feed
from openrois_bench.streams.peers.janus import janus
from openrois_bench.streams.peers.network import inside
from openrois_bench.streams.peers.programs import Child, child

FORWARDER = Path(__file__).with_name("build") / "forwarder"
_RTP_PORT = 18004
_WARM_UP = 2.0
_CONNECTING = 20.0

Add = Callable[[int], Awaitable[None]]
"""Connects a viewer."""


async def _ours(stack: AsyncExitStack, ask: Answering) -> tuple[int, Add]:
    published = Published()
    return os.getpid(), lambda number: send_with_ours(stack, number, published, ask)


async def _aiortc(stack: AsyncExitStack, ask: Answering) -> tuple[int, Add]:
    published = Published()
    return os.getpid(), lambda number: send_with_aiortc(stack, number, published, ask)


async def _plain(stack: AsyncExitStack, ask: Answering) -> tuple[int, Add]:
    source = pictures()
    return os.getpid(), lambda number: send_with_plain(stack, number, source, ask)


async def _janus(stack: AsyncExitStack, ask: Answering) -> tuple[int, Add]:
    running = await stack.enter_async_context(janus(_RTP_PORT))
    await stack.enter_async_context(_fed())

    async def add(number: int) -> None:
        await running.apply_answer(number, await ask(number, await running.offer(number)))

    return running.pid, add


async def _pion(stack: AsyncExitStack, ask: Answering) -> tuple[int, Add]:
    running: Child = await stack.enter_async_context(child(str(FORWARDER), str(_RTP_PORT)))
    await stack.enter_async_context(_fed())

    async def add(number: int) -> None:
        offer = await running.ask(offer=number)
        await running.ask(answer=number, sdp=await ask(number, offer["sdp"]))

    return running.process.pid, add


KINDS = {"ours": _ours, "aiortc": _aiortc, "plain": _plain, "janus": _janus, "pion": _pion}


@asynccontextmanager
async def _fed() -> Any:
    async with asyncio.TaskGroup() as tasks:
        feeding = tasks.create_task(feed(_RTP_PORT))
        yield
        feeding.cancel()


async def measure(kind: str, viewers: int, seconds: float, namespace: str) -> dict[str, Any]:
    """CPU seconds per second of what sends, and what came."""
    async with AsyncExitStack() as stack:
        watching = await stack.enter_async_context(
            child(*inside(namespace, sys.executable, "-m", "openrois_bench.streams.peers.viewers"))
        )

        async def ask(_number: int, sdp: str) -> str:
            return str((await watching.ask(sdp=sdp))["sdp"])

        pid, add = await KINDS[kind](stack, ask)
        for number in range(viewers):
            await add(number)
        async with asyncio.timeout(_CONNECTING):
            while (await watching.ask())["connected"] < viewers:  # noqa: ASYNC110 - another process is asked
                await asyncio.sleep(0.1)
        await asyncio.sleep(_WARM_UP)
        spent = partial(cpu_of, pid)
        before, count, began = spent(), await watching.ask(), time.monotonic()
        await asyncio.sleep(seconds)
        passed = time.monotonic() - began
        used, arrived = spent() - before, await watching.ask()
    return {
        "kind": kind,
        "viewers": viewers,
        "cpu": used / passed,
        "packets_per_viewer": (arrived["packets"] - count["packets"]) / passed / viewers,
        "kbits_per_viewer": (arrived["octets"] - count["octets"]) * 8 / 1000 / passed / viewers,
        "load": os.getloadavg()[0],
    }


if __name__ == "__main__":
    print(json.dumps(uvloop.run(measure(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4]))))
