"""Reconnection of an engine that outlives its adapter."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Final

from openrois_avatar.link.client import LinkClient
from openrois_avatar.link.messages import LinkError

FIRST_DELAY: Final = 0.5
LONGEST_DELAY: Final = 5.0
"""Seconds between two attempts; the delay doubles from the first to the longest, and starts over after WELCOME."""


def connections(
    connect: Callable[[], LinkClient],
    failed: Callable[[str], None] = lambda _reason: None,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[LinkClient]:
    """Yield one connection after another, each as soon as the adapter answers; never ends by itself.

        for link in connections(lambda: LinkClient.connect(address, hello)):
            with link:
                while link.connected:
                    ...

    Args:
        connect: makes a connection.
        failed: called with the reason when an attempt fails; an adapter that refuses may accept later.
        sleep: waits for so many seconds.
    """
    delay = FIRST_DELAY
    while True:
        try:
            link = connect()
        except LinkError as error:
            failed(str(error))
        else:
            yield link
            delay = FIRST_DELAY
        sleep(delay)
        delay = min(2 * delay, LONGEST_DELAY)
