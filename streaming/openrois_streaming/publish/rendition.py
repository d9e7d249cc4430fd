"""Rendition: one encoding of one source, made once and shared by every viewer that plays it."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import AsyncIterator, Callable, Hashable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeVar

from openrois_streaming.adaptation.demand import CoarseRate, Demands
from openrois_streaming.adaptation.rung import Rung
from openrois_streaming.clock import MediaClock
from openrois_streaming.codecs import VP8
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.encoding import EncodedSource, Encoding
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.source.fanout import DropOldest, Fanout, Mailbox, Subscription
from openrois_streaming.source.source import MediaSource

RawT = TypeVar("RawT")

# Smaller changes of the bit rate are not passed to the encoder.
_TOLERANCE = 0.03

_log = logging.getLogger(__name__)


class KeyFrameMailbox:
    """Mailbox of a viewer of predicted pictures: those it hands out can be decoded without those it lost.

    It begins with the first key frame. When `maxsize` pictures are waiting and another one comes, all are lost, up to
    the next key frame. `ask` is called for one when the reader is back: before, it would only burden the other viewers.
    """

    __slots__ = ("_ask", "_items", "_lossy", "_maxsize", "_waiting")

    def __init__(self, maxsize: int, ask: Callable[[], None]) -> None:
        if maxsize < 1:
            raise ValueError(f"maxsize must be 1 or more, not {maxsize}")
        self._items: deque[EncodedFrame] = deque()
        self._maxsize = maxsize
        self._ask = ask
        self._waiting = True
        self._lossy = False

    def put(self, item: EncodedFrame) -> int:
        """Queue `item` if it can be decoded; returns how many were lost, none before the first key frame."""
        if self._waiting and not item.keyframe:
            return int(self._lossy)
        lost = 0
        if len(self._items) >= self._maxsize:
            lost = len(self._items)
            self._items.clear()
            if not item.keyframe:
                self._waiting = self._lossy = True
                return lost + 1
        self._waiting = False
        self._items.append(item)
        return lost

    def pop(self) -> EncodedFrame:
        """Remove and return the oldest picture."""
        return self._items.popleft()

    def awaited(self) -> None:
        """Request a key frame, if there was a loss and none has come since."""
        if self._waiting and self._lossy:
            self._ask()

    def __len__(self) -> int:
        return len(self._items)


class DirectMailbox:
    """Mailbox of a viewer that is sent each frame at once: none waits, and none is lost here."""

    __slots__ = ("_on_frame",)

    def __init__(self, on_frame: Callable[[EncodedFrame], None]) -> None:
        self._on_frame = on_frame

    def put(self, item: EncodedFrame) -> int:
        """Pass `item` on; a failure to do so affects this viewer alone."""
        try:
            self._on_frame(item)
        except Exception:
            _log.exception("a frame could not be passed to a viewer")
        return 0

    def pop(self) -> EncodedFrame:
        """Never called: it is always empty."""
        raise LookupError

    def awaited(self) -> None:
        """Nothing to do."""

    def __len__(self) -> int:
        return 0


@dataclass(frozen=True, slots=True)
class RenditionFigures:
    """Figures of a rendition since it was made; its encoder may have run several times."""

    mime_type: str
    running: bool
    """Whether the encoder runs now."""
    viewers: int
    """Number of open subscriptions."""
    bitrate: int
    """The target in bit/s."""
    encoded: int
    """Frames encoded."""
    encoded_bytes: int
    key_frames: int
    """Key frames encoded; each block of sound counts as one."""
    starts: int
    """Key frames forced for viewers that started."""
    repairs: int
    """Key frames forced for viewers that lost data."""
    dropped_input: int
    """Raw frames that were lost because the encoder was busy."""
    encode_seconds: float
    """Time spent in the encoder, scaling and colour conversion included."""
    size: str = ""
    """Width, height and pace, as in "640x360@30"; empty for sound."""


class FrameKind(Protocol):
    """Kind of a rendition's frames."""

    @property
    def mime_type(self) -> str:
        """`video/H264`, `video/VP8` or `audio/opus`."""
        ...

    @property
    def clock_rate(self) -> int:
        """Units of the frames' times, per second."""
        ...

    @property
    def predicted(self) -> bool:
        """Whether most frames can only be decoded after those before them."""
        ...


class FrameSource(MediaSource[EncodedFrame], Protocol):
    """Source of a rendition's frames, encoded or passed on; its counters are those of `RenditionFigures`."""

    bitrate: int
    encoded: int
    encoded_bytes: int
    key_frames: int
    forced: dict[KeyFrameCause, int]

    @property
    def dropped_input(self) -> int:
        """Frames that were lost before they were encoded or passed on."""
        ...

    @property
    def encode_seconds(self) -> float:
        """Time spent in the encoder."""
        ...

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Make one of the next frames a key frame, as soon as the budget of `cause` allows."""
        ...

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s)."""
        ...


def encoded_rendition(
    raw: Fanout[RawT],
    encoding: Encoding[RawT],
    *,
    clock: MediaClock,
    bitrate: int,
    demands: Demands | None = None,
) -> Rendition:
    """Return a rendition of raw frames, with an encoder of its own."""
    source = EncodedSource(raw, encoding, clock=clock, bitrate=bitrate)
    return Rendition(source, encoding, name=f"{raw.name} {encoding.mime_type}", clock=clock, demands=demands)


class Rendition:
    """Rendition of one source: one media type, size and bit rate.

    Its encoder runs, in a thread of its own, from the first subscription to the last. When the encoder or the source
    fails, every subscription ends with `SourceEnded` and the failure as its cause; the next one restarts both.
    """

    def __init__(
        self, source: FrameSource, kind: FrameKind, *, name: str, clock: MediaClock, demands: Demands | None = None
    ) -> None:
        self._kind = kind
        self._clock = clock
        self._demands = demands
        self._coarse = CoarseRate() if kind.mime_type == VP8 else None
        self._source = source
        self._fanout: Fanout[EncodedFrame] = Fanout(source, name=name)
        self._wanted = 0

    @property
    def mime_type(self) -> str:
        """`video/H264`, `video/VP8` or `audio/opus`."""
        return self._kind.mime_type

    @property
    def clock_rate(self) -> int:
        """Units of `EncodedFrame.pts` per second."""
        return self._kind.clock_rate

    @property
    def running(self) -> bool:
        """Whether the encoder runs: there is a subscription, and no failure."""
        return self._fanout.running

    @property
    def failure(self) -> Exception | None:
        """The last failure of the encoder or the source, until a frame comes or it is no longer `wanted`."""
        return self._fanout.failure if self._wanted else None

    @property
    def was_played(self) -> bool:
        """Whether its encoder runs or has encoded a frame."""
        return self.running or self._source.encoded > 0

    @property
    def is_wanted(self) -> bool:
        """Whether a viewer plays it, or tries to."""
        return self._wanted > 0

    @contextmanager
    def wanted(self) -> Iterator[None]:
        """Count it as played while the context lasts, also between two tries; earlier failures are cleared."""
        if not self._wanted:
            self._fanout.failure = None
        self._wanted += 1
        try:
            yield
        finally:
            self._wanted -= 1

    @asynccontextmanager
    async def subscribe(self, maxsize: int = 8) -> AsyncIterator[Subscription[EncodedFrame]]:
        """Play this rendition while the context lasts; a viewer that is suspended leaves it.

        A subscription to video begins with a key frame, which is requested here. A reader that lets more than `maxsize`
        frames wait loses some: of sound the oldest, of video all up to the next key frame, which is requested, as a
        repair, when it reads again.
        """
        mailbox: Mailbox[EncodedFrame]
        if self._kind.predicted:
            mailbox = KeyFrameMailbox(maxsize, partial(self.request_key_frame, KeyFrameCause.REPAIR))
        else:
            mailbox = DropOldest(maxsize)
        with self.wanted():
            async with self._fanout.subscribe(mailbox=mailbox) as subscription:
                self.request_key_frame(KeyFrameCause.START)
                yield subscription

    @property
    def rung(self) -> Rung | None:
        """Size, pace and bounds of the bit rate; None for sound."""
        return None if self._demands is None else self._demands.rung

    def suit(self, rung: Rung, tolerance: float) -> None:
        """Set the rung and tolerance of this rendition, which follow from the size of the source."""
        if self._demands is not None and self._demands.suit(rung, tolerance):
            self._follow()

    @asynccontextmanager
    async def play(
        self, viewer: Hashable, on_frame: Callable[[EncodedFrame], None], bitrate: float | None = None
    ) -> AsyncIterator[Subscription[EncodedFrame]]:
        """Play this rendition while the context lasts: `on_frame` is called in the loop with each frame at once.

        A key frame is requested here, but `on_frame` gets what comes before it too. The yielded subscription has no
        items: its `get` raises `SourceEnded` when the source or the encoder has ended.

        Args:
            viewer: key of the viewer.
            on_frame: gets each frame; must not block.
            bitrate: the viewer's demand, in bit/s.
        """
        try:
            if bitrate is not None:
                self.demand(viewer, bitrate)
            with self.wanted():
                async with self._fanout.subscribe(mailbox=DirectMailbox(on_frame)) as subscription:
                    self.request_key_frame(KeyFrameCause.START)
                    yield subscription
        finally:
            if self._demands is not None:
                self._demands.drop(viewer)
                self._follow()

    @asynccontextmanager
    async def prepare(self) -> AsyncIterator[None]:
        """Run source and encoder while the context lasts, for a viewer without a media path yet."""
        with self.wanted():
            async with self._fanout.subscribe(mailbox=DirectMailbox(lambda _frame: None)):
                yield

    def demand(self, viewer: Hashable, bitrate: float) -> None:
        """Set the demand of `viewer` to `bitrate` (bit/s)."""
        if self._demands is not None:
            self._demands.put(viewer, bitrate)
            self._follow()

    def least(self, viewer: Hashable) -> float:
        """Return the least demand (bit/s) with which `viewer` can play this rendition."""
        return 0.0 if self._demands is None else self._demands.least(viewer)

    def _follow(self) -> None:
        if self._demands is None or not self._demands.viewers:
            return
        bitrate = self._demands.bitrate
        if self._coarse is not None:
            bitrate = self._coarse.follow(bitrate, self._demands.rung, self._clock.now())
        if abs(bitrate - self._source.bitrate) > _TOLERANCE * self._source.bitrate:
            self._source.set_bitrate(bitrate)

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Request a key frame; it comes as soon as the budget of `cause` allows, and serves all waiting viewers."""
        self._source.request_key_frame(cause)

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s) from the next frame on, for all viewers.

        The encoder keeps within its bounds. H.264 follows without a key frame; VP8 starts anew on a change by more
        than a tenth, Opus on any.
        """
        self._source.set_bitrate(bitrate)

    def figures(self) -> RenditionFigures:
        """Return a snapshot of the counters."""
        source = self._source
        return RenditionFigures(
            mime_type=self.mime_type,
            running=self.running,
            viewers=self._fanout.readers,
            bitrate=source.bitrate,
            encoded=source.encoded,
            encoded_bytes=source.encoded_bytes,
            key_frames=source.key_frames,
            starts=source.forced[KeyFrameCause.START],
            repairs=source.forced[KeyFrameCause.REPAIR] + source.forced[KeyFrameCause.STILL],
            dropped_input=source.dropped_input,
            encode_seconds=source.encode_seconds,
            size="" if self.rung is None else f"{self.rung.width}x{self.rung.height}@{self.rung.frame_rate:g}",
        )
