"""Pictures that their source has encoded itself: passed on as they come, and only cut into packets, once for all."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import H264
from openrois_streaming.encoded import VIDEO_CLOCK_RATE, EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameBudget, KeyFrameCause
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.source.source import EncodedVideo, EncodingSource

_TOLERANCE: Final = 0.1
"""Share of the bit rate by which a new one has to differ to be worth asking the source for."""


@dataclass(frozen=True, slots=True)
class PassedOnKind:
    """What pictures are that come encoded."""

    mime_type: str = H264
    clock_rate: int = VIDEO_CLOCK_RATE
    predicted: bool = True


class PassedOn:
    """The frames of an `EncodingSource`, in packets; a `FrameSource` of a `Rendition`.

    What cannot be decoded, after a picture that is missing or before the first key frame, is lost here, and counted in
    `dropped_input`. Nothing is encoded, so no time is spent on it.
    """

    def __init__(self, source: EncodingSource, *, clock: MediaClock, bitrate: int) -> None:
        self.encoded = 0
        self.encoded_bytes = 0
        self.key_frames = 0
        self.forced = dict.fromkeys(KeyFrameCause, 0)
        self.bitrate = bitrate
        self.dropped_input = 0
        self.encode_seconds = 0.0
        self.last_frame_at: float | None = None
        """When the source last gave a picture, on the media clock; None if it has given none since it was opened."""
        self.size: tuple[int, int] | None = None
        """Width and height of the last picture, None before the first one."""
        self._source = source
        self._clock = clock
        self._budget = KeyFrameBudget()
        self._told_bitrate = 0
        self._open = False
        self._pts = -1

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Ask the source for a key frame, as soon as the budget of `cause` allows."""
        self._budget.request(cause)
        self._ask()

    def set_bitrate(self, bitrate: int) -> None:
        """Ask the source to aim at `bitrate` (bit/s), now and whenever it is opened again."""
        self.bitrate = bitrate
        if self._open and abs(bitrate - self._told_bitrate) > _TOLERANCE * self._told_bitrate:
            self._told_bitrate = bitrate
            self._source.set_bitrate(bitrate)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedFrame]]:
        """Open the source and pass on what it gives."""
        self.last_frame_at, self._told_bitrate = None, 0
        async with self._source.open() as pictures:
            # A viewer that joined while the source still closed may have asked in vain.
            self._budget.restart()
            self._open = True
            try:
                self.set_bitrate(self.bitrate)
                self._ask()
                yield self._frames(pictures)
            finally:
                self._open = False

    def _ask(self) -> None:
        cause = self._budget.take(self._clock.now()) if self._open else None
        if cause is not None:
            self.forced[cause] += 1
            self._source.request_key_frame()

    async def _frames(self, pictures: AsyncIterator[EncodedVideo]) -> AsyncIterator[EncodedFrame]:
        following: int | None = None
        """The number of the only picture, beside key frames, that can be decoded next."""
        async for picture in pictures:
            self.last_frame_at, self.size = self._clock.now(), (picture.width, picture.height)
            if picture.keyframe:
                self._budget.served()
            elif picture.sequence != following:
                self.dropped_input += 1
                if following is not None:
                    self._budget.request(KeyFrameCause.REPAIR)
                following = None
                self._ask()
                continue
            following = picture.sequence + 1
            self._ask()
            yield self._frame(picture)

    def _frame(self, picture: EncodedVideo) -> EncodedFrame:
        self._pts = max(round(picture.captured_at * VIDEO_CLOCK_RATE), self._pts + 1)
        payloads = payloads_of(H264, picture.data)
        number = self.encoded
        self.encoded += 1
        self.encoded_bytes += len(picture.data)
        self.key_frames += picture.keyframe
        return EncodedFrame(
            picture.data, payloads, self._pts, VIDEO_CLOCK_RATE, picture.keyframe, number, picture.captured_at
        )
