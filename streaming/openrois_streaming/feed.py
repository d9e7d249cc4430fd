"""Brings the frames of a shared rendition to one track, for as long as its stream is open."""

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager
from typing import Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.keyframes import KeyFrameCause
from openrois_streaming.stats import Counters
from openrois_streaming.track import PacketTrack, ReferenceChain

RETRY = 1.0
"""Seconds after which a source that ended or failed is opened again."""

_log = logging.getLogger(__name__)


class FrameReader(Protocol):
    """One reader of a rendition, with a bounded queue of its own."""

    @property
    def dropped(self) -> int:
        """Frames that this reader lost because it was too slow."""
        ...

    async def get(self) -> EncodedFrame:
        """The next frame; raises when the source has ended or failed."""
        ...


class SharedRendition(Protocol):
    """One encoding of a source, which runs while somebody reads it."""

    def subscribe(self) -> AbstractAsyncContextManager[FrameReader]:
        """Read it while the context lasts; a key frame is asked for, to start with."""
        ...

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Have the next frame encoded as a key frame, within the budget of the cause."""
        ...


class MediaPublisher(Protocol):
    """A source that can be had in several encodings."""

    def rendition(self, mime_type: str) -> SharedRendition:
        """Its encoding of that media type."""
        ...


async def feed(find: Callable[[], SharedRendition], track: PacketTrack, counters: Counters, clock: MediaClock) -> None:
    """Deliver the frames of the rendition that `find` gives to `track` until cancelled; tries again when it fails."""
    failing = False
    while True:
        try:
            rendition = find()
            async with rendition.subscribe() as reader:
                async for frame in _decodable(rendition, reader, track, counters):
                    await track.deliver(frame)
                    failing = False
        except Exception as error:
            if not failing:
                cause = error.__cause__ or error
                _log.warning("a %s source stopped; it is tried again every %.0f s: %r", track.kind, RETRY, cause)
            failing = True
        await clock.sleep_until(clock.now() + RETRY)


async def _decodable(
    rendition: SharedRendition, reader: FrameReader, track: PacketTrack, counters: Counters
) -> AsyncIterator[EncodedFrame]:
    """The frames of `reader` that its viewer can decode; asks for a key frame where there is a gap."""
    chain = ReferenceChain(track.kind)
    track.clear()
    lost = counters.frames_dropped
    while True:
        frame = await reader.get()
        if chain.admits(frame):
            yield frame
        else:
            lost += 1
            if chain.should_ask(frame):
                rendition.request_key_frame(KeyFrameCause.REPAIR)
        counters.frames_dropped = lost + reader.dropped
