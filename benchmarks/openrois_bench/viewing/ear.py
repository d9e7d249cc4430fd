"""What a viewer hears of an avatar, and when: by the moments of the sound, and by the clock of this process."""

import asyncio
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

import numpy as np
from openrois_signaling.messages import Offer
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.testing import MeasuringSink

if TYPE_CHECKING:
    from openrois.gateway.server import Gateway

__all__ = ["LOUD", "Ear", "listening"]

LOUD: Final = 2_000
"""Of 32,767; Opus begins a tone at full height within a few ms."""


class Ear:
    """What a viewer hears: moment and time of hearing of the first and the last loud sample since `forget_heard`.

    Args:
        loud: what is loud, of 32,767.
    """

    def __init__(self, loud: int = LOUD) -> None:
        self._loud = loud
        self.first: tuple[float, float] | None = None
        self.last = (0.0, 0.0)
        self._came = asyncio.Event()

    def forget_heard(self) -> None:
        """Forget what was heard."""
        self.first = None

    def note_block(self, media: RawVideo | RawAudio) -> None:
        """Note a block that is played now."""
        if isinstance(media, RawAudio):
            heard = time.monotonic()
            loud = [at / 48_000 for at in np.flatnonzero(np.abs(media.samples[:, 0]) > self._loud).tolist()]
            if loud:
                self.first = self.first or (media.captured_at + loud[0], heard + loud[0])
                self.last = (media.captured_at + loud[-1], heard + loud[-1])
            self._came.set()

    async def until(self, so: Callable[[], bool]) -> None:
        """Wait until something is so when a block is played."""
        while not so():
            self._came.clear()
            await self._came.wait()

    async def loud_for(self, seconds: float) -> None:
        """Wait until sound has been heard for so long."""
        await self.until(lambda: self.first is not None and time.monotonic() - self.first[1] >= seconds)

    async def silent_for(self, seconds: float) -> None:
        """Wait until silence has been heard for so long."""
        await self.until(lambda: time.monotonic() - self.last[1] >= seconds)


@asynccontextmanager
async def listening(gateway: "Gateway", loud: int = LOUD) -> AsyncIterator[Ear]:
    """A viewer of its own that hears the avatar."""
    from tests.support.deployment import application  # a wheel has no tests

    ear = Ear(loud)
    async with MeasuringSink(on_media=ear.note_block) as sink, application(gateway) as app:
        await app.ask("openrois.hello", version="1", extensions=[])
        assert (
            await app.code("rois.stream.connect_stream", component_ref="avatar/audio_streaming", parameters=[]) == "OK"
        )
        offer = Offer.model_validate(await app.next("signaling.offer"))
        assert await app.code("signaling.answer", **(await sink.respond(offer)).wire()) == "OK"
        await sink.hears(50)
        yield ear
