"""Speaks a file of sound through a body: `speak.py FILE.wav [URL]`. The file is mono, 16 bits, at 16, 24 or 48 kHz."""

import asyncio
import sys
import wave

import numpy as np
from openrois_media import Media

from openrois.client import Client


async def main(path: str, url: str = "ws://127.0.0.1:8765/") -> None:
    """Push the file as it is read, and say what was heard of it."""
    with wave.open(path) as file:
        rate = file.getframerate()
        async with Client(url) as client, Media(client) as media, media.speech(rate=rate) as speech:
            while data := file.readframes(rate // 10):
                await speech.push(np.frombuffer(data, np.int16))
            spoken = await speech.finish()
    print(f"{spoken.seconds:.1f} s were heard{f', then {spoken.reason}' if spoken.interrupted else ''}")


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
