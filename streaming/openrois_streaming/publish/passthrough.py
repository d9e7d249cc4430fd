"""Video that its source encodes itself: passed on as it comes, cut into packets once for all viewers."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from typing import Final

from openrois_signaling.messages import MediaKind

from openrois_streaming.adaptation.demand import LOWEST, Demands
from openrois_streaming.adaptation.rung import MIN_BITRATE, Rung, ladder
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import H264, VP8, CodecUnavailable
from openrois_streaming.encoded import VIDEO_CLOCK_RATE, EncodedFrame
from openrois_streaming.errors import words_of
from openrois_streaming.publish.key_frames import KeyFrameBudget, KeyFrameCause
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.publish.rendition import Rendition
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.source.source import EncodedVideo, EncodingSource

_TOLERANCE: Final = 0.1
"""Least relative change of the bit rate that is requested of the source."""
NO_KEY_FRAME: Final = 10
"""Seconds of pictures that no viewer can decode, after which their source has failed."""


class NoKeyFrame(Exception):
    """Lack of key frames in pictures that come encoded."""


@dataclass(frozen=True, slots=True)
class PassthroughKind:
    """Frame kind of pictures that come encoded."""

    mime_type: str
    clock_rate: int = VIDEO_CLOCK_RATE
    predicted: bool = True


class PassthroughSource:
    """Frames of an `EncodingSource`, in packets; a `FrameSource` of a `Rendition`.

    Pictures that cannot be decoded, after a missing one or before the first key frame, are dropped here, and counted in
    `dropped_input`. There is no encoder, so `encode_seconds` stays 0. The iterator raises `NoKeyFrame` when none could
    be decoded for `NO_KEY_FRAME` seconds; a source that is opened anew most often begins with one.
    """

    def __init__(self, source: EncodingSource, *, clock: MediaClock, bitrate: int, mime_type: str = H264) -> None:
        self.encoded = 0
        self.encoded_bytes = 0
        self.key_frames = 0
        self.forced = dict.fromkeys(KeyFrameCause, 0)
        self.bitrate = bitrate
        self.dropped_input = 0
        self.encode_seconds = 0.0
        self.last_frame_at: float | None = None
        """Time of the source's last picture, on the media clock; None if it has given none since it was opened."""
        self.size: tuple[int, int] | None = None
        """Width and height of the last picture, None before the first one."""
        self._mime_type = mime_type
        self._source = source
        self._clock = clock
        self._budget = KeyFrameBudget()
        self._requested_bitrate = 0
        self._open = False
        self._pts = -1

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Ask the source for a key frame, as soon as the budget of `cause` allows."""
        self._budget.request(cause)
        self._ask()

    def set_bitrate(self, bitrate: int) -> None:
        """Ask the source to aim at `bitrate` (bit/s), now and whenever it is opened again."""
        self.bitrate = bitrate
        if self._open and abs(bitrate - self._requested_bitrate) > _TOLERANCE * self._requested_bitrate:
            self._requested_bitrate = bitrate
            self._source.set_bitrate(bitrate)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedFrame]]:
        """Open the source and pass on its pictures."""
        self.last_frame_at, self._requested_bitrate = None, 0
        async with self._source.open() as pictures:
            # A viewer that joined while the source was closing may have asked in vain.
            self._budget.restart()
            self._open = True
            try:
                self.set_bitrate(self.bitrate)
                self._ask()
                yield self._frames(pictures)
            finally:
                self._open = False

    def _ask(self) -> None:
        cause = self._budget.take_cause(self._clock.now()) if self._open else None
        if cause is not None:
            self.forced[cause] += 1
            self._source.request_key_frame()

    async def _frames(self, pictures: AsyncIterator[EncodedVideo]) -> AsyncIterator[EncodedFrame]:
        following: int | None = None
        """Number of the only predicted picture that can be decoded next."""
        undecodable_since: float | None = None
        async for picture in pictures:
            now = self._clock.now()
            self.last_frame_at, self.size = now, (picture.width, picture.height)
            if picture.keyframe:
                self._budget.served()
            elif picture.sequence != following:
                self.dropped_input += 1
                if following is not None:
                    self._budget.request(KeyFrameCause.REPAIR)
                following = None
                undecodable_since = now if undecodable_since is None else undecodable_since
                if now - undecodable_since >= NO_KEY_FRAME:
                    raise NoKeyFrame(f"no key frame in {NO_KEY_FRAME} s: let the encoder give one every two seconds")
                self._ask()
                continue
            undecodable_since = None
            following = picture.sequence + 1
            self._ask()
            yield self._frame(picture)

    def _frame(self, picture: EncodedVideo) -> EncodedFrame:
        self._pts = max(round(picture.captured_at * VIDEO_CLOCK_RATE), self._pts + 1)
        payloads = payloads_of(self._mime_type, picture.data)
        number = self.encoded
        self.encoded += 1
        self.encoded_bytes += len(picture.data)
        self.key_frames += picture.keyframe
        return EncodedFrame(
            picture.data, payloads, self._pts, VIDEO_CLOCK_RATE, picture.keyframe, number, picture.captured_at
        )


class EncodedPublisher:
    """Publisher of pictures that come encoded, in their one codec and size; a `Publishing`.

    All viewers share the bit rate that the slowest of them can take: the source has the only encoder. Pictures get no
    stamp, and none are left out for viewers that want fewer a second.

    Args:
        source: where the pictures come from.
        clock: the media clock that its capture times are of.
        frame_rate: expected pictures per second of the source.
        size: expected width and height, until the first picture.
        max_bitrate: the highest rate that is requested, in bit/s; None: as much as is of use for its size.
        mime_type: what they are encoded as, "video/H264" or "video/VP8".
        name: its name in the log.

    Raises:
        CodecUnavailable: pictures of that media type cannot be passed on.
    """

    kind: Final[MediaKind] = "video"

    def __init__(
        self,
        source: EncodingSource,
        *,
        clock: MediaClock,
        mime_type: str = H264,
        frame_rate: float = 30.0,
        size: tuple[int, int] = (1280, 720),
        max_bitrate: int | None = None,
        name: str = "video",
    ) -> None:
        self._frame_rate, self._size, self._max_bitrate = frame_rate, size, max_bitrate
        self._name = name
        self._mime_type = _passable(mime_type)
        rung = self._rung(size)
        self._passthrough = PassthroughSource(source, clock=clock, bitrate=rung.max_bitrate, mime_type=self._mime_type)
        kind = PassthroughKind(self._mime_type)
        self._rendition = Rendition(
            self._passthrough, kind, name=f"{name} {self._mime_type}", clock=clock, demands=Demands(rung, LOWEST)
        )

    def codecs(self) -> tuple[str, ...]:
        """Return the only media type."""
        return (self._mime_type,)

    def expect(self, frame_rate: float, size: tuple[int, int]) -> None:
        """Set the frame rate, width and height that are expected of the source from now on."""
        self._frame_rate, self._size = frame_rate, size
        self._passthrough.size = None

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """Return the only rendition.

        Raises:
            CodecUnavailable: the media type is another one.
        """
        if mime_type.lower() != self._mime_type.lower():
            raise CodecUnavailable(f"the source is encoded as {self._mime_type} already: ask for that codec")
        self._rendition.suit(self._rung(self._passthrough.size or self._size), LOWEST)
        return (self._rendition,)

    def has_room(self, mime_type: str) -> bool:
        """Always true: there is no encoder to wait for."""
        return True

    def can_encode(self, mime_type: str) -> bool:
        """Always true: a failing encoder is the engine's, and there is no other codec."""
        return True

    @property
    def made(self) -> tuple[Rendition, ...]:
        """The rendition, if it was played."""
        return (self._rendition,) if self._rendition.was_played else ()

    @property
    def running_encoders(self) -> int:
        """1 while the rendition has a viewer, else 0."""
        return int(self._rendition.running)

    @property
    def frames(self) -> int:
        """Pictures received from the source so far."""
        return self._passthrough.encoded + self._passthrough.dropped_input

    @property
    def failure(self) -> str:
        """A sentence on the failure of the wanted source, while no picture has come since; empty without one."""
        failure = self._rendition.failure
        return "" if failure is None else f"the source of {self._name} has failed: {words_of(failure)}"

    @property
    def last_frame_at(self) -> float | None:
        """Time of the source's last picture, on the media clock; None if it has given none since it was opened."""
        return self._passthrough.last_frame_at

    def _rung(self, size: tuple[int, int]) -> Rung:
        first = ladder(*size, self._frame_rate, max_bitrate=self._max_bitrate)[0]
        return replace(first, min_bitrate=MIN_BITRATE)


class SwitchingPublisher:
    """Publisher that switches between raw and pre-encoded video; a `Publishing`.

    Args:
        raw: publishes the pictures that are encoded here.
        encoded: publishes the pictures that come encoded.
        comes_encoded: whether pictures come encoded now.
    """

    kind: Final[MediaKind] = "video"

    def __init__(self, raw: VideoPublisher, encoded: EncodedPublisher, comes_encoded: Callable[[], bool]) -> None:
        self._raw = raw
        self._encoded = encoded
        self._comes_encoded = comes_encoded

    def codecs(self) -> tuple[str, ...] | None:
        """Return the only media types available now; None: all that can be encoded here."""
        return (H264,) if self._comes_encoded() else None

    def expect(self, frame_rate: float, size: tuple[int, int]) -> None:
        """Set the frame rate, width and height that are expected from now on."""
        self._raw.expect(frame_rate, size)
        self._encoded.expect(frame_rate, size)

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """Return the renditions available now, the largest first.

        Raises:
            CodecUnavailable: there are none in this media type now.
        """
        return (self._encoded if self._comes_encoded() else self._raw).renditions(mime_type, fps)

    def has_room(self, mime_type: str) -> bool:
        """Tell whether a viewer can be played something in that media type now."""
        return (self._encoded if self._comes_encoded() else self._raw).has_room(mime_type)

    def can_encode(self, mime_type: str) -> bool:
        """Tell whether its encoders of that media type work, as far as is known."""
        return (self._encoded if self._comes_encoded() else self._raw).can_encode(mime_type)

    @property
    def made(self) -> tuple[Rendition, ...]:
        """All renditions that were played so far."""
        return (*self._raw.made, *self._encoded.made)

    @property
    def running_encoders(self) -> int:
        """Number of renditions that run now."""
        return self._raw.running_encoders + self._encoded.running_encoders

    @property
    def frames(self) -> int:
        """Pictures received from either source so far."""
        return self._raw.frames + self._encoded.frames

    @property
    def failure(self) -> str:
        """A sentence on the failure of the present source."""
        return (self._encoded if self._comes_encoded() else self._raw).failure

    @property
    def last_frame_at(self) -> float | None:
        """Time of the last picture, on the media clock; None if none came since the sources were opened."""
        return max(
            (at for at in (self._raw.last_frame_at, self._encoded.last_frame_at) if at is not None), default=None
        )


def _passable(mime_type: str) -> str:
    for known in (H264, VP8):
        if known.lower() == mime_type.lower():
            return known
    raise CodecUnavailable(f"pictures encoded as {mime_type!r} cannot be passed on: use {H264} or {VP8}")
