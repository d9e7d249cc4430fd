"""Pacing of synthetic sources."""

import math
from collections.abc import AsyncIterator

from openrois_streaming.clock import MediaClock


async def due(
    clock: MediaClock, epoch: float, rate: float, *, patience: int, after: int | None = None
) -> AsyncIterator[int]:
    """Yield the numbers n, each when `epoch + n / rate` has come, and of those that are late at most `patience`.

    The first is the next that is due. With `after` it is the one that was due last, at once, if it is later than that.
    """
    number = math.ceil((clock.now() - epoch) * rate - 1e-6)
    if after is not None:
        number = max(after + 1, math.floor((clock.now() - epoch) * rate + 1e-6))
    while True:
        await clock.sleep_until(epoch + number / rate)
        number = max(number, math.floor((clock.now() - epoch) * rate) - patience)
        yield number
        number += 1
