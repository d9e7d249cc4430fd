"""A game engine, a process of its own, that sends small grey pictures and a hum; SIGUSR1 has it send nonsense."""

import os
import random
import signal
import sys
import time
from typing import Final

import numpy as np
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Hello, Quit, VideoShape
from openrois_avatar.link.protocol import PixelFormat

WIDTH, HEIGHT, FPS = 160, 90, 20
_HUM: Final = (np.sin(np.arange(48_000 // FPS) * 0.05) * 3000).astype(np.int16)[:, np.newaxis]


def main() -> None:
    """Play until it is told to end, or its link is over."""
    hello = Hello("small", "1", VideoShape(WIDTH, HEIGHT, FPS, "i420"), 1, ("nod",), "")
    signal.signal(signal.SIGUSR1, lambda *_: None)
    with connect_from_environment(hello) as link:
        signal.signal(signal.SIGUSR1, lambda *_: garble(link))
        due, number = time.monotonic(), 0
        while link.connected:
            due += 1 / FPS
            if any(isinstance(each, Quit) for each in link.poll_commands(max(0.0, due - time.monotonic()))):
                return
            now, number = time.monotonic_ns(), number + 1
            picture = np.full((HEIGHT * 3 // 2, WIDTH), 128, np.uint8)
            picture[:HEIGHT] = 60 + number % 120
            link.send_video(picture.tobytes(), WIDTH, HEIGHT, WIDTH, PixelFormat.I420, now)
            link.send_audio(_HUM, now)


def garble(link: LinkClient) -> None:
    """Send bytes that are no message, in between the others."""
    chance = random.Random(os.getpid())
    link._stream.sendall(chance.randbytes(chance.randint(64, 4096)))


if __name__ == "__main__":
    sys.exit(main())
