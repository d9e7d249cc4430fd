"""An application's pictures and sound go on when the adapter's process, or the gateway's, is killed."""

import asyncio
import time
from pathlib import Path

import pytest
from openrois_media import Media

from openrois.client import Client, Reconnect
from tests.support.demo import PATIENCE, running_demo
from tests.support.spectator import AUDIO, VIDEO

pytestmark = [pytest.mark.media, pytest.mark.long]


async def test_killed_programs_are_followed_by_their_successors(tmp_path: Path) -> None:
    with running_demo(tmp_path) as demo:
        async with (
            Client(demo.url, reconnect=Reconnect(first=0.1, limit=0.5)) as client,
            Media(client) as media,
            media.frames(VIDEO, "i420") as frames,
            media.blocks(AUDIO) as blocks,
        ):
            for program in ("avatar", "gateway"):
                async with asyncio.timeout(PATIENCE):
                    await anext(frames)
                    await anext(blocks)
                killed = demo.program(program)
                killed.kill()
                async with asyncio.timeout(PATIENCE):
                    while frames.status is not None and frames.status.value != "STREAMING_NOT_CONNECTED":
                        await anext(blocks)
                    while frames.status is None or frames.status.value != "STREAMING_RUNNING":
                        await anext(frames)
                    at = time.monotonic()
                    while (await anext(frames)).local_time < at:
                        pass
