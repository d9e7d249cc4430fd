"""A source and all that is played of it: pulled once, stamped once, and encoded once for each rendition."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from typing import Generic, TypeVar

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.codecs import CodecUnavailable, codec_named
from openrois_streaming.encoded import AUDIO_CLOCK_RATE, VIDEO_CLOCK_RATE
from openrois_streaming.encoder_audio import OpusEncoder
from openrois_streaming.encoder_video import VideoEncoder
from openrois_streaming.encoding import Encoding
from openrois_streaming.fanout import Fanout
from openrois_streaming.rendition import Rendition
from openrois_streaming.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.stamp import stamped

RawT = TypeVar("RawT")

# Blocks of sound that may wait for the encoder: with 20 ms each, a stall of 0.2 s loses nothing.
_SOUND_DEPTH = 10


class _HandOver(Generic[RawT]):
    """A source as it is handed to the encoders: it is seen to advance, and each frame gets its finish."""

    def __init__(self, source: MediaSource[RawT], clock: MediaClock, finish: Callable[[RawT], RawT] | None) -> None:
        self.last_frame_at: float | None = None
        self._source = source
        self._clock = clock
        self._finish = finish

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawT]]:
        self.last_frame_at = None
        async with self._source.open() as items:
            yield self._hand_over(items)

    async def _hand_over(self, items: AsyncIterator[RawT]) -> AsyncIterator[RawT]:
        async for item in items:
            self.last_frame_at = self._clock.now()
            yield item if self._finish is None else self._finish(item)


class Publisher(Generic[RawT]):
    """Shares one source among its renditions. The source is open only while somebody is subscribed to one of them."""

    def __init__(
        self,
        source: MediaSource[RawT],
        encoding_for: Callable[[str], Encoding[RawT]],
        *,
        clock: MediaClock,
        bitrate: int,
        name: str,
        finish: Callable[[RawT], RawT] | None = None,
    ) -> None:
        self._encoding_for = encoding_for
        self._clock = clock
        self._bitrate = bitrate
        self._source = _HandOver(source, clock, finish)
        self._raw: Fanout[RawT] = Fanout(self._source, name=name)
        self._renditions: dict[str, Rendition[RawT]] = {}

    def rendition(self, mime_type: str) -> Rendition[RawT]:
        """The rendition of a media type: the same one for all who ask.

        Raises:
            CodecUnavailable: this source cannot be encoded so, here or at all.
        """
        name = codec_named(mime_type)
        if name not in self._renditions:
            encoding = self._encoding_for(name)
            self._renditions[name] = Rendition(self._raw, encoding, clock=self._clock, bitrate=self._bitrate)
        return self._renditions[name]

    @property
    def renditions(self) -> tuple[Rendition[RawT], ...]:
        """All renditions that were asked for so far."""
        return tuple(self._renditions.values())

    @property
    def running_encoders(self) -> int:
        """How many encoders run now: one for each rendition that has a viewer."""
        return sum(rendition.running for rendition in self._renditions.values())

    @property
    def frames(self) -> int:
        """Raw frames taken from the source so far."""
        return self._raw.pulled

    @property
    def last_frame_at(self) -> float | None:
        """When the source last gave a frame, on the media clock; None if it has given none since it was opened."""
        return self._source.last_frame_at


class VideoPublisher(Publisher[RawVideo]):
    """Publishes pictures as `video/H264` and `video/VP8`.

    Args:
        source: where the pictures come from; they must be at least 160 pixels wide if they are to be stamped.
        clock: the media clock that the source's capture times are of.
        stamp: whether each picture carries its number and the wall time of its capture, see `stamp`.
        bitrate: of each rendition at first, in bit/s.
        frame_rate: frames per second that the source is expected to give.
        name: what it is called in the log.
    """

    def __init__(
        self,
        source: MediaSource[RawVideo],
        *,
        clock: MediaClock,
        stamp: bool = False,
        bitrate: int = 1_500_000,
        frame_rate: float = 30.0,
        name: str = "video",
    ) -> None:
        super().__init__(
            source,
            partial(_video_encoding, frame_rate),
            clock=clock,
            bitrate=bitrate,
            name=name,
            finish=(lambda raw: stamped(raw, wall_at(clock, raw.captured_at))) if stamp else None,
        )


class AudioPublisher(Publisher[RawAudio]):
    """Publishes sound as `audio/opus`.

    Args:
        source: where the sound comes from.
        clock: the media clock that the source's capture times are of.
        bitrate: of the rendition at first, in bit/s.
        name: what it is called in the log.
    """

    def __init__(
        self, source: MediaSource[RawAudio], *, clock: MediaClock, bitrate: int = 64_000, name: str = "audio"
    ) -> None:
        super().__init__(source, _audio_encoding, clock=clock, bitrate=bitrate, name=name)


def _video_encoding(frame_rate: float, mime_type: str) -> Encoding[RawVideo]:
    if not mime_type.startswith("video/"):
        raise CodecUnavailable(f"pictures cannot be encoded as {mime_type}")
    return Encoding(
        mime_type=mime_type,
        clock_rate=VIDEO_CLOCK_RATE,
        make_encoder=lambda bitrate: VideoEncoder(mime_type, bitrate=bitrate, frame_rate=frame_rate),
        predicted=True,
        depth=1,
    )


def _audio_encoding(mime_type: str) -> Encoding[RawAudio]:
    if not mime_type.startswith("audio/"):
        raise CodecUnavailable(f"sound cannot be encoded as {mime_type}")
    return Encoding(
        mime_type=mime_type,
        clock_rate=AUDIO_CLOCK_RATE,
        make_encoder=lambda bitrate: OpusEncoder(bitrate=bitrate),
        predicted=False,
        depth=_SOUND_DEPTH,
    )
