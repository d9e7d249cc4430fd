"""Publishers: a source is pulled once, stamped once, and encoded once for each rendition."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final, Generic, Protocol, TypeVar

from openrois_signaling.messages import MediaKind

from openrois_streaming.adaptation.demand import LOWEST, MIDDLE, TOP, Demands
from openrois_streaming.adaptation.rung import Rung, Thinning, every_for, ladder
from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.codecs import CodecUnavailable, codec_named
from openrois_streaming.encoded import AUDIO_CLOCK_RATE, VIDEO_CLOCK_RATE
from openrois_streaming.errors import NoEncoder, words_of
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.publish.encoder_health import EncoderHealth
from openrois_streaming.publish.encoder_limit import EncoderLimit
from openrois_streaming.publish.encoding import Encoding
from openrois_streaming.publish.rendition import Rendition, encoded_rendition
from openrois_streaming.publish.rendition_feed import MediaPublisher
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.fanout import Fanout
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.source.stamp import stamped

RawT = TypeVar("RawT")

# Greatest age, in frame times, at which a picture is encoded again for a viewer that joins, resumes or lost data.
_FRESH = 2.0

# Blocks of sound that may wait for the encoder: with 20 ms each, a stall of 0.2 s loses nothing.
_SOUND_DEPTH = 10


class _HandOver(Generic[RawT]):
    """Source as the encoders read it: its last frame is noted, and each frame gets its finish."""

    def __init__(self, source: MediaSource[RawT], clock: MediaClock, finish: Callable[[RawT], RawT]) -> None:
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
            yield self._finish(item)


class Publishing(MediaPublisher, Protocol):
    """Publisher with the figures of its source."""

    @property
    def kind(self) -> MediaKind:
        """Kind of its media."""
        ...

    def codecs(self) -> tuple[str, ...] | None:
        """Return the only media types available now; None: all that can be encoded here."""
        ...

    @property
    def made(self) -> tuple[Rendition, ...]:
        """Renditions that were played so far."""
        ...

    @property
    def running_encoders(self) -> int:
        """Number of renditions that run now: those with a viewer."""
        ...

    @property
    def frames(self) -> int:
        """Frames received from the source so far."""
        ...

    @property
    def failure(self) -> str:
        """A sentence on the failure of a wanted rendition, while no frame has come since; empty without one."""
        ...

    @property
    def last_frame_at(self) -> float | None:
        """Time of the source's last frame, on the media clock; None if it has given none since it was opened."""
        ...


class Publisher(Generic[RawT]):
    """Source shared among its renditions. It is open only while a viewer plays one of them."""

    def __init__(
        self,
        source: MediaSource[RawT],
        *,
        clock: MediaClock,
        name: str,
        finish: Callable[[RawT], RawT] = lambda raw: raw,
    ) -> None:
        self._clock = clock
        self._source = _HandOver(source, clock, finish)
        self._raw: Fanout[RawT] = Fanout(self._source, name=name)
        self._made: dict[tuple[object, ...], Rendition] = {}
        self._health = EncoderHealth()

    def codecs(self) -> tuple[str, ...] | None:
        """Return None: all that can be encoded here is available."""
        return None

    def has_room(self, mime_type: str) -> bool:
        """Tell whether a viewer can be sent that media type now."""
        return True

    def can_encode(self, mime_type: str) -> bool:
        """Tell whether encoders of that media type work: false while they fail again and again."""
        codec = codec_named(mime_type)
        failures = [each.failure for key, each in self._made.items() if key[0] == codec and each.is_wanted]
        # No codec helps where the source fails.
        works = None in failures or self._source_fails
        return self._health.is_usable(codec, None if works else next(iter(failures), None), self._clock.now())

    @property
    def made(self) -> tuple[Rendition, ...]:
        """Renditions that were played so far."""
        return tuple(each for each in self._made.values() if each.was_played)

    @property
    def running_encoders(self) -> int:
        """Number of encoders that run now: one for each rendition with a viewer."""
        return sum(rendition.running for rendition in self._made.values())

    @property
    def frames(self) -> int:
        """Raw frames received from the source so far."""
        return self._raw.pulled

    @property
    def _source_fails(self) -> bool:
        """Whether wanted renditions fail because of the source, not of an encoder."""
        # The source's failure may be of an earlier play; a rendition that fails now because of it has the same failure.
        failure = self._raw.failure
        return failure is not None and any(each.failure is failure for each in self._made.values())

    @property
    def failure(self) -> str:
        """A sentence on the failure of a wanted rendition, while no frame has come since; empty without one."""
        failures = [(each, each.failure) for each in self._made.values() if each.failure is not None]
        if not failures:
            return ""
        failed, failure = failures[0]
        if self._source_fails:
            # A rendition that fails because of the source has the same failure.
            failure = self._raw.failure or failure
            return f"the source of {self._raw.name} has failed: {words_of(failure)}"
        return f"the encoder of {self._raw.name} ({failed.mime_type}) has failed: {words_of(failure)}"

    @property
    def last_frame_at(self) -> float | None:
        """Time of the source's last frame, on the media clock; None if it has given none since it was opened."""
        return self._source.last_frame_at


class VideoPublisher(Publisher[RawVideo]):
    """Publisher of pictures as `video/H264` and `video/VP8`, in several sizes.

    Args:
        source: where the pictures come from.
        clock: the media clock that the source's capture times are of.
        stamp: whether each picture carries its number and the wall time of its capture, see `stamp`; too small pictures
            carry none.
        frame_rate: expected frames per second of the source.
        size: expected width and height, until the first frame.
        max_bitrate: the highest bit rate of a rendition, in bit/s; None: as much as is of use for its size.
        encoders: limit on renditions that are encoded at a time, which sources may share; None: one of its own.
        name: its name in the log.
    """

    kind: Final[MediaKind] = "video"

    def __init__(
        self,
        source: MediaSource[RawVideo],
        *,
        clock: MediaClock,
        stamp: bool = False,
        frame_rate: float = 30.0,
        size: tuple[int, int] = (1280, 720),
        max_bitrate: int | None = None,
        encoders: EncoderLimit | None = None,
        name: str = "video",
    ) -> None:
        super().__init__(source, clock=clock, name=name, finish=self._finished)
        self._encoders = encoders or EncoderLimit()
        self._encoders.add_source(self._made.values)
        self._stamp = stamp
        self._frame_rate = frame_rate
        self._size = size
        self._max_bitrate = max_bitrate

    def expect(self, frame_rate: float, size: tuple[int, int]) -> None:
        """Another frame rate, and width and height, are to be expected of the source from now on."""
        self._frame_rate, self._size = frame_rate, size

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """Return the renditions of a media type, the largest first: the same ones for all viewers.

        Args:
            mime_type: "video/H264" or "video/VP8".
            fps: pictures per second that are enough; None: all of them.

        Raises:
            CodecUnavailable: this source cannot be encoded in this media type.
            NoEncoder: all encoders are in use, and none of them has this media type.
        """
        codec = codec_named(mime_type)
        if not codec.startswith("video/"):
            raise CodecUnavailable(f"{codec} is no video codec: use video/H264 or video/VP8")
        asked = self._ladder(codec, every_for(self._frame_rate, fps))
        first = asked[0] if fps is None else self._ladder(codec, 1)[0]
        return self._encoders.choose(asked, first, self._made.values())

    def has_room(self, mime_type: str) -> bool:
        """Tell whether a viewer can be sent that media type now."""
        try:
            return bool(self.renditions(mime_type))
        except NoEncoder:
            return False

    def _ladder(self, codec: str, every: int) -> tuple[Rendition, ...]:
        rungs = ladder(*self._size, self._frame_rate, every=every, max_bitrate=self._max_bitrate)
        return tuple(self._rendition(codec, rung, last=rung is rungs[-1]) for rung in rungs)

    def _rendition(self, codec: str, rung: Rung, *, last: bool) -> Rendition:
        key = (codec, rung.halvings, rung.every)
        tolerance = LOWEST if last else TOP if rung.halvings == 0 else MIDDLE
        rendition = self._made.get(key)
        if rendition is None:
            demands = Demands(rung, tolerance)
            encoding = _video_encoding(codec, demands)
            rendition = self._made[key] = encoded_rendition(
                self._raw, encoding, clock=self._clock, bitrate=rung.max_bitrate, demands=demands
            )
        rendition.suit(rung, tolerance)
        return rendition

    def _finished(self, raw: RawVideo) -> RawVideo:
        self._size = (raw.width, raw.height)
        return stamped(raw, wall_at(self._clock, raw.captured_at)) if self._stamp else raw


class AudioPublisher(Publisher[RawAudio]):
    """Publisher of sound as `audio/opus`.

    Args:
        source: where the sound comes from.
        clock: the media clock that the source's capture times are of.
        bitrate: of the rendition, in bit/s.
        name: its name in the log.
    """

    kind: Final[MediaKind] = "audio"

    def __init__(
        self, source: MediaSource[RawAudio], *, clock: MediaClock, bitrate: int = 64_000, name: str = "audio"
    ) -> None:
        super().__init__(source, clock=clock, name=name)
        self._bitrate = bitrate

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """Return the only rendition of a media type; `fps` is ignored for sound.

        Raises:
            CodecUnavailable: this source cannot be encoded in this media type.
        """
        codec = codec_named(mime_type)
        if (codec,) not in self._made:
            encoding = _audio_encoding(codec)
            self._made[codec,] = encoded_rendition(self._raw, encoding, clock=self._clock, bitrate=self._bitrate)
        return (self._made[codec,],)


def _video_encoding(mime_type: str, demands: Demands) -> Encoding[RawVideo]:
    rung = demands.rung
    thinning = Thinning(rung.frame_rate)

    def make_encoder(bitrate: int) -> VideoEncoder:
        return VideoEncoder(
            mime_type,
            bitrate=bitrate,
            frame_rate=rung.frame_rate,
            max_bitrate=demands.rung.max_bitrate,
            halvings=rung.halvings,
            size=(demands.rung.width, demands.rung.height),
        )

    return Encoding(
        mime_type=mime_type,
        clock_rate=VIDEO_CLOCK_RATE,
        make_encoder=make_encoder,
        predicted=True,
        depth=1,
        choose=None if rung.every == 1 else lambda raw: thinning.wants(raw.captured_at),
        is_fresh=lambda raw, now: now - raw.captured_at <= _FRESH / demands.rung.frame_rate,
    )


def _audio_encoding(mime_type: str) -> Encoding[RawAudio]:
    if not mime_type.startswith("audio/"):
        raise CodecUnavailable(f"{mime_type} is no audio codec: use audio/opus")
    return Encoding(
        mime_type=mime_type,
        clock_rate=AUDIO_CLOCK_RATE,
        make_encoder=lambda bitrate: OpusEncoder(bitrate=bitrate),
        predicted=False,
        depth=_SOUND_DEPTH,
    )
