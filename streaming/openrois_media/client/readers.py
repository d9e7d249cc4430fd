"""Frames and sound of a stream, as an application reads them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.receive.decoded import DecodedPicture
from openrois_streaming.source.av_frames import FrameFormat
from openrois_streaming.source.fanout import SourceEnded, Subscription
from openrois_streaming.source.source import ReceivedAudio

from openrois.types.codes import StreamStatus
from openrois_media.client.stream import ReceivedStream
from openrois_media.client.stream_state import Desire

__all__ = ["Block", "Frame", "StreamReader", "block_of", "frame_of"]

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A decoded picture.

    Attributes:
        data: its pixels, uint8 of the shape (height, width, 3) for `rgb24` and `bgr24`; for `i420` (height * 3 / 2,
            width): the Y plane, then U, then V, BT.601 limited range. Readers of one stream may share them: copy them
            before you change them.
        format: the pixel format of `data`.
        width: in pixels.
        height: in pixels.
        captured_at: when it was captured, in seconds since the epoch on the sender's clock, by the sender's reports
            (RFC 3550 section 6.4.1); None before the first of them, usually in the first second.
        local_time: when it was captured, on this machine's clock (`time.monotonic()` unless the `Media` has another).
            Where `captured_at` is None it is an estimate, by the arrival of the fastest packet; otherwise it is late by
            the least travel time of a packet, so that `time.monotonic() - frame.local_time` is its age without that.
    """

    data: NDArray[np.uint8]
    format: FrameFormat
    width: int
    height: int
    captured_at: float | None
    local_time: float


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A block of sound, 20 ms long at most.

    Attributes:
        samples: int16 of the shape (n, 2), 48 kHz, stereo.
        captured_at: when its first sample was captured; as in `Frame`.
        local_time: the same on this machine's clock; as in `Frame`.
    """

    samples: NDArray[np.int16]
    captured_at: float | None
    local_time: float

    sample_rate: Final = 48_000


def frame_of(picture: DecodedPicture, pixel_format: FrameFormat) -> Frame:
    """Return a picture in a pixel format."""
    pixels = picture.pixels(pixel_format)
    size = picture.width, picture.height
    return Frame(pixels, pixel_format, *size, picture.reported_at, picture.captured_at)


def block_of(block: ReceivedAudio) -> Block:
    """Return a block of sound."""
    return Block(block.samples, block.reported_at, block.captured_at)


class StreamReader(Generic[T]):
    """Reader of a stream: `async for frame in frames`. It is inside its `async with` block.

    It goes on over lost connections, restarted engines and replaced peer connections, and waits meanwhile: `status` and
    `problem` tell why nothing comes. What it is too slow for is dropped, oldest first. It ends with its `Media`.
    """

    def __init__(
        self,
        stream: ReceivedStream,
        subscription: Subscription[Any],
        convert: Callable[[Any], T],
        clock: MediaClock,
        on_desire: Callable[[], None],
    ) -> None:
        self.desire = Desire.RUNNING
        """What this reader wants the stream to be; the stream runs as long as one of its readers wants that."""
        self._stream = stream
        self._subscription = subscription
        self._convert = convert
        self._clock = clock
        self._on_desire = on_desire
        self._since = float("-inf")

    @property
    def component_ref(self) -> str:
        """Reference of the component whose stream it is."""
        return self._stream.component_ref

    @property
    def status(self) -> StreamStatus | None:
        """Status of the stream that the engine has reported last; None without a connection to the gateway."""
        return self._stream.state.status

    @property
    def problem(self) -> str:
        """What keeps the stream from running, in a sentence; it is tried again. Empty for nothing."""
        return self._stream.problem

    @property
    def dropped(self) -> int:
        """Number of frames that this reader was too slow for."""
        return self._subscription.dropped

    async def suspend(self) -> None:
        """Read nothing until `resume`. Media stops to flow, and to be decoded, when all readers are suspended.

        Returns once the engine has agreed, or cannot be asked now: it is then as soon as it can.
        """
        await self._want(Desire.SUSPENDED)

    async def resume(self) -> None:
        """Go on with what is captured from now on; returns as `suspend`."""
        self._since = self._clock.now()
        await self._want(Desire.RUNNING)

    async def disconnected(self) -> None:
        """Wait until the engine has ended the stream, or knows none: a visitor has left, or withdrawn its consent."""
        stream = self._stream
        await stream.news.until(lambda: self.status is StreamStatus.STREAMING_NOT_CONNECTED or stream.is_unknown)

    async def _want(self, desire: Desire) -> None:
        self.desire = desire
        self._on_desire()
        await self._stream.settled()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        while True:
            try:
                item: DecodedPicture | ReceivedAudio = await self._subscription.get()
            except SourceEnded as end:
                if end.__cause__ is not None:
                    raise end.__cause__ from None
                raise StopAsyncIteration from None
            if self.desire is Desire.RUNNING and item.captured_at >= self._since:
                return self._convert(item)
