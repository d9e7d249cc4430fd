"""Reading from one connection without holding up the others, whatever its messages cost."""

import asyncio
from collections.abc import Awaitable, Callable
from time import perf_counter
from typing import Final, NoReturn

__all__ = ["FAIR_SHARE", "FAIR_TEXT", "FAIR_TIME", "fair_share", "read_fairly"]

FAIR_SHARE: Final = 64
"""Messages of one connection that are read in a row at most; then other tasks have their turn."""

FAIR_TEXT: Final = 16 * 1024
"""Characters of them after which other tasks have their turn, too."""

FAIR_TIME: Final = 0.01
"""Seconds that a turn of the loop may take until fewer are read in a row: some cost a thousand times others."""


async def read_fairly(receive: Callable[[], Awaitable[str]], take: Callable[[str], None]) -> NoReturn:
    """Read and handle messages for ever.

    Args:
        receive: waits for the next message; what it raises ends this.
        take: begins to do what a message asks for.
    """
    share = fair_share()
    while True:
        room = FAIR_TEXT
        for _ in range(share):
            text = await receive()
            take(text)
            room -= len(text)
            if room < 0:
                break
        before = perf_counter()
        await asyncio.sleep(0)
        # By now what was asked has run as far as it does without waiting, and others had their turn.
        share = fair_share(share, perf_counter() - before)


def fair_share(share: int = 2, turn: float = 0.0) -> int:
    """Return how many messages may be read in a row after a turn of the loop; without one, how many at first.

    Args:
        share: how many were taken.
        turn: seconds that they and all other tasks took.
    """
    return max(1, share // 4) if turn > FAIR_TIME else min(FAIR_SHARE, share * 2)
