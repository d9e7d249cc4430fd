"""An application needs no OpenCV: it runs in a process in which that cannot be imported."""

import asyncio
import sys

import pytest

from tests.support.loopback import PATIENCE
from tests.support.media_body import CAMERA, MICROPHONE, body

APPLICATION = """
import asyncio, sys
from contextlib import asynccontextmanager

sys.modules["cv2"] = None  # an import raises ModuleNotFoundError

import numpy as np
from openrois_media import Media
from openrois_streaming.source.source import RawVideo

from openrois.client import Client


class Grey:
    @asynccontextmanager
    async def open(self):
        async def frames():
            for number in range(1000):
                await asyncio.sleep(0.05)
                yield RawVideo(np.full((120, 160, 3), 128, np.uint8), "bgr24", 160, 120, number, number / 20)
        yield frames()


async def main(url, camera, microphone):
    async with Client(url) as client, Media(client) as media:
        async with media.frames(camera) as frames, media.blocks(microphone) as blocks, media.send(camera=Grey()):
            print((await anext(frames)).data.shape, (await anext(blocks)).samples.shape[1])
        print((await media.snapshot(camera))[:2].hex())


import openrois_media.recording.record_command, openrois_media.recording.snapshot_command
asyncio.run(main(*sys.argv[1:]))
"""


@pytest.mark.media
async def test_an_application_without_opencv() -> None:
    async with body() as robot:
        pipe = asyncio.subprocess.PIPE
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", APPLICATION, robot.url, CAMERA, MICROPHONE, stdout=pipe, stderr=pipe
        )
        async with robot.screen.subscribe(1) as screen, asyncio.timeout(PATIENCE):
            picture = asyncio.ensure_future(screen.get())
            out, err = await process.communicate()
            picture.cancel()
        assert process.returncode == 0, err.decode()
        assert out.decode().split("\n") == ["(180, 320, 3) 2", "ffd8", ""]
