"""The life of components: connected to what they depend on, retried where that fails, and disconnected at the end."""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable
from contextlib import asynccontextmanager

from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.transport.backoff import Backoff

__all__ = ["connected"]

_log = logging.getLogger(__name__)


@asynccontextmanager
async def connected(
    components: Iterable[Component], *, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
) -> AsyncIterator[None]:
    """Keep components connected while the block runs; it does not wait for them, their status tells.

    A `connect` that fails is tried again after 1 s, then half as long again each time, at most 30 s. In the end
    `disconnect` is run of all that were connected, side by side, each for a few seconds at most.

    Args:
        components: what is connected.
        sleep: waits for some seconds between attempts.
    """
    chosen = tuple(components)
    try:
        async with TaskScope() as tasks:
            for component in chosen:
                tasks.start(_bring_up(component, sleep))
            yield
    finally:
        await asyncio.gather(*(component.take_down() for component in chosen))


async def _bring_up(component: Component, sleep: Callable[[float], Awaitable[None]]) -> None:
    backoff = Backoff()
    while not await component.bring_up():
        delay = backoff.after(0)
        _log.info("%s: trying again in %.1f s", component.name, delay)
        await sleep(delay)
