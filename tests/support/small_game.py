"""A game engine, a process of its own, that sends small pictures and a hum; it does as signals say.

SIGUSR1: send nonsense in between. SIGUSR2: send pictures of another size from now on, odd ones too.
"""

import os
import random
import signal
import time
from typing import Final

import numpy as np
from openrois_avatar.link.client import LinkClient, connect_from_environment
from openrois_avatar.link.messages import Hello, Quit, VideoShape
from openrois_avatar.link.protocol import PixelFormat

WIDTH, HEIGHT, FPS = 160, 90, 20
_HUM: Final = (np.sin(np.arange(48_000 // FPS) * 0.05) * 3000).astype(np.int16)[:, np.newaxis]


def main() -> None:
    """Play until the command to end, or until its link is over."""
    hello = Hello("small", "1", VideoShape(WIDTH, HEIGHT, FPS), 1, ("nod",), "")
    size, chance = [WIDTH, HEIGHT], random.Random(os.environ["SMALL_GAME_SEED"])

    def resize(*_: object) -> None:
        size[:] = chance.randrange(64, 320), chance.randrange(64, 240)

    with connect_from_environment(hello) as link:
        signal.signal(signal.SIGUSR1, lambda *_: garble(link, chance))
        signal.signal(signal.SIGUSR2, resize)
        due, number = time.monotonic(), 0
        while link.connected:
            due += 1 / FPS
            if any(isinstance(each, Quit) for each in link.poll_commands(max(0.0, due - time.monotonic()))):
                return
            now, number = time.monotonic_ns(), number + 1
            width, height = size
            picture = np.full((height, width, 4), 60 + number % 120, np.uint8)
            link.send_video(picture.tobytes(), width, height, width * 4, PixelFormat.BGRA, now)
            link.send_audio(_HUM, now)


def garble(link: LinkClient, chance: random.Random) -> None:
    """Send bytes that are no message, in between the others."""
    link._stream.sendall(chance.randbytes(chance.randint(64, 4096)))


if __name__ == "__main__":
    main()
