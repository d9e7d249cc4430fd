"""Viewers that join and leave, a process of its own.

`python -m openrois_bench.soak.viewers ws://127.0.0.1:8765/ 4 SEED`. It prints a line for each visit that went well, and
may be killed at any time.
"""

import asyncio
import random
import sys
from contextlib import AsyncExitStack
from typing import Final

import uvloop

from openrois_bench.errors import BenchFailed
from openrois_bench.viewing.application import Playing, application

VIDEO: Final = "avatar/video_streaming"
CODECS: Final = ("video/H264", "video/VP8")
VISIT: Final = (1.0, 5.0)
"""Seconds that a visit lasts, from and to."""


async def _watch(playing: Playing, seconds: float) -> None:
    end = asyncio.get_running_loop().time() + seconds
    while asyncio.get_running_loop().time() < end:
        await playing.picture()


async def _visit(url: str, dice: random.Random) -> None:
    async with AsyncExitStack() as stack:
        app = await stack.enter_async_context(application(url))
        codec = CODECS[dice.random() < 0.25]
        playing = await stack.enter_async_context(app.playing(VIDEO, codec))
        await _watch(playing, dice.uniform(*VISIT))
        if dice.random() < 0.3:
            await playing.suspend()
            await asyncio.sleep(dice.uniform(0.1, 1.0))
            await playing.resume()
            await _watch(playing, 1.0)


async def _come_and_go(url: str, dice: random.Random) -> None:
    while True:
        try:
            await _visit(url, dice)
            print("visit", flush=True)
        except (BenchFailed, OSError) as error:
            print(f"failed {error}", flush=True)
        await asyncio.sleep(dice.uniform(0.1, 1.0))


async def _run(url: str, count: int, seed: int) -> None:
    await asyncio.gather(*(_come_and_go(url, random.Random(seed + number)) for number in range(count)))


if __name__ == "__main__":
    uvloop.run(_run(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
