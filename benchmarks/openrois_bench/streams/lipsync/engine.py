"""A game engine with sound of its own: colour bars, and the tone's markers, over the engine link. Run by `scenes`.

It sends each block of sound when its first sample is due, as one does that knows nothing of what comes.
"""

import asyncio

import uvloop
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Hello, VideoShape
from openrois_avatar.link.protocol import PixelFormat
from openrois_streaming.clock import SystemClock
from openrois_streaming.synthetic import ColourBars, Tone

_WIDTH, _HEIGHT, _FPS = 1280, 720, 30


async def _run(link: LinkClient) -> None:
    clock = SystemClock()
    sounding = asyncio.create_task(_sound(link, clock))
    async with ColourBars(_WIDTH, _HEIGHT, _FPS, clock=clock).open() as pictures:
        async for picture in pictures:
            moment = round(picture.captured_at * 1e9)
            link.send_video(picture.data.tobytes(), _WIDTH, _HEIGHT, _WIDTH, PixelFormat.I420, moment)
            link.poll_commands()
            if not link.connected:
                break
    sounding.cancel()


async def _sound(link: LinkClient, clock: SystemClock) -> None:
    async with Tone(clock=clock).open() as blocks:
        async for block in blocks:
            link.send_audio(block.samples, round(block.captured_at * 1e9))


if __name__ == "__main__":
    greeting = Hello("marks", "1", VideoShape(_WIDTH, _HEIGHT, _FPS, "i420"), audio_channels=1)
    with connect_from_environment(greeting) as connection:
        uvloop.run(_run(connection))
