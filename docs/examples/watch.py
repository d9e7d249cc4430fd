"""Tells how bright it is where the camera of a body looks, and how loud it is there: `watch.py [SECONDS [URL]]`."""

import asyncio
import sys
import time

import numpy as np
from openrois_media import Media

from openrois.client import Client
from openrois.client.components import AudioStreaming, VideoStreaming


async def main(seconds: str = "5", url: str = "ws://127.0.0.1:8765/") -> None:
    """Print a line a second, for so many seconds."""
    async with Client(url) as client, Media(client) as media:
        camera, microphone = await client.find(VideoStreaming), await client.find(AudioStreaming)
        async with media.frames(camera, "i420") as frames, media.blocks(microphone) as blocks:
            for _ in range(int(seconds)):
                loudest = max([np.abs((await anext(blocks)).samples).max() for _ in range(50)])
                frame = await anext(frames)
                brightness = frame.data[: frame.height].mean() / 255
                age = time.monotonic() - frame.local_time
                print(f"brightness {brightness:.0%}, loudness {loudest / 32768:.0%}, seen {1000 * age:.0f} ms ago")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
