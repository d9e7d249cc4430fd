"""Publishing a source that encodes its pictures itself, alone or in turn with one whose pictures are encoded here."""

from collections.abc import Callable
from dataclasses import replace

from openrois_streaming.adaptation.demand import LOWEST, Demands
from openrois_streaming.adaptation.rung import MIN_BITRATE, Rung, ladder
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import H264, CodecUnavailable
from openrois_streaming.publish.passthrough import PassedOn, PassedOnKind
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.publish.rendition import Rendition
from openrois_streaming.source.source import EncodingSource


class EncodedPublisher:
    """Publishes pictures that come encoded, as `video/H264` in the one size there is; a `Publishing`.

    All viewers share what the slowest of them can take: there is one encoder, and it is the source's. Neither is a
    stamp put into the pictures, nor are any left out for who wants fewer a second.

    Args:
        source: where the pictures come from.
        clock: the media clock that its capture times are of.
        frame_rate: pictures per second that it is expected to give.
        size: width and height that it is expected to give, until the first picture shows what it does.
        max_bitrate: the most that it is asked for, in bit/s; None: as much as is of use for its size.
        name: what it is called in the log.
    """

    def __init__(
        self,
        source: EncodingSource,
        *,
        clock: MediaClock,
        frame_rate: float = 30.0,
        size: tuple[int, int] = (1280, 720),
        max_bitrate: int | None = None,
        name: str = "video",
    ) -> None:
        self._frame_rate, self._size, self._max_bitrate = frame_rate, size, max_bitrate
        self._name = name
        rung = self._rung(size)
        self._passed_on = PassedOn(source, clock=clock, bitrate=rung.max_bitrate)
        self._rendition = Rendition(
            self._passed_on, PassedOnKind(), name=f"{name} {H264}", clock=clock, demands=Demands(rung, LOWEST)
        )

    def expect(self, frame_rate: float, size: tuple[int, int]) -> None:
        """Another frame rate, and width and height, are to be expected of the source from now on."""
        self._frame_rate, self._size = frame_rate, size
        self._passed_on.size = None

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """The one rendition there is.

        Raises:
            CodecUnavailable: another media type is asked for.
        """
        if mime_type.lower() != H264.lower():
            raise CodecUnavailable(f"the source gives {H264} and nothing else")
        self._rendition.suit(self._rung(self._passed_on.size or self._size), LOWEST)
        return (self._rendition,)

    def has_room(self, mime_type: str) -> bool:
        """Whether a viewer can be played something in that media type: nothing is encoded here."""
        return True

    def can_encode(self, mime_type: str) -> bool:
        """Always so: an encoder that fails is the engine's, and another codec cannot be had."""
        return True

    @property
    def made(self) -> tuple[Rendition, ...]:
        """The rendition, if it was played so far."""
        return (self._rendition,) if self._rendition.was_played else ()

    @property
    def running_encoders(self) -> int:
        """Whether it has a viewer now, as a number."""
        return int(self._rendition.running)

    @property
    def frames(self) -> int:
        """Pictures taken from the source so far."""
        return self._passed_on.encoded + self._passed_on.dropped_input

    @property
    def failure(self) -> str:
        """A sentence on what failed, if it is wanted and no picture has come since; empty where nothing did."""
        failure = self._rendition.failure
        return "" if failure is None else f"the source of {self._name} has failed: {failure!r}"

    @property
    def last_frame_at(self) -> float | None:
        """When the source last gave a picture, on the media clock; None if it has given none since it was opened."""
        return self._passed_on.last_frame_at

    def _rung(self, size: tuple[int, int]) -> Rung:
        first = ladder(*size, self._frame_rate, max_bitrate=self._max_bitrate)[0]
        return replace(first, min_bitrate=MIN_BITRATE)


class EitherPublisher:
    """Publishes pictures of which now the one kind is to be had and now the other; a `Publishing`.

    Args:
        raw: publishes those that are encoded here.
        encoded: publishes those that come encoded.
        comes_encoded: which of the two there are now.
    """

    def __init__(self, raw: VideoPublisher, encoded: EncodedPublisher, comes_encoded: Callable[[], bool]) -> None:
        self._raw = raw
        self._encoded = encoded
        self._comes_encoded = comes_encoded

    def codecs(self) -> tuple[str, ...] | None:
        """The only media types that there are now; None: all that can be encoded here."""
        return (H264,) if self._comes_encoded() else None

    def expect(self, frame_rate: float, size: tuple[int, int]) -> None:
        """Another frame rate, and width and height, are to be expected from now on."""
        self._raw.expect(frame_rate, size)
        self._encoded.expect(frame_rate, size)

    def renditions(self, mime_type: str, fps: float | None = None) -> tuple[Rendition, ...]:
        """Those that are to be had now, the largest first.

        Raises:
            CodecUnavailable: not in this media type, now or at all.
        """
        return (self._encoded if self._comes_encoded() else self._raw).renditions(mime_type, fps)

    def has_room(self, mime_type: str) -> bool:
        """Whether a viewer can be played something in that media type now."""
        return (self._encoded if self._comes_encoded() else self._raw).has_room(mime_type)

    def can_encode(self, mime_type: str) -> bool:
        """Whether its encoders of that media type work, as far as is known."""
        return (self._encoded if self._comes_encoded() else self._raw).can_encode(mime_type)

    @property
    def made(self) -> tuple[Rendition, ...]:
        """All renditions that were played so far."""
        return (*self._raw.made, *self._encoded.made)

    @property
    def running_encoders(self) -> int:
        """How many renditions run now."""
        return self._raw.running_encoders + self._encoded.running_encoders

    @property
    def frames(self) -> int:
        """Pictures taken from either so far."""
        return self._raw.frames + self._encoded.frames

    @property
    def failure(self) -> str:
        """A sentence on what failed, of the kind that there is now."""
        return (self._encoded if self._comes_encoded() else self._raw).failure

    @property
    def last_frame_at(self) -> float | None:
        """When the last picture came, on the media clock; None if none has since they were opened."""
        return max(
            (at for at in (self._raw.last_frame_at, self._encoded.last_frame_at) if at is not None), default=None
        )
