"""Source of encoded frames that a rendition's viewers share, made of raw frames."""

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Generic, TypeVar, cast

from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.encoder import Encoder
from openrois_streaming.publish.encoder_thread import EncoderHung, EncoderThread
from openrois_streaming.publish.key_frames import KeyFrameBudget, KeyFrameCause
from openrois_streaming.source.fanout import Fanout, SourceEnded, Subscription

RawT = TypeVar("RawT")

MAX_ABANDONED = 3
"""Encoders that may hang at a time; beyond that none is started."""

# Seconds between two reports of frames that were lost before the encoder.
_REPORT_INTERVAL = 10.0

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Encoding(Generic[RawT]):
    """Recipe of an encoded source."""

    mime_type: str
    clock_rate: int
    """Units of the encoded frames' times, per second."""
    make_encoder: Callable[[int], Encoder[RawT]]
    """Makes an encoder for a bit rate (bit/s); called in the encoder's thread, and so is what it returns."""
    predicted: bool
    """Whether most frames can be decoded only after those before them."""
    depth: int
    """How many raw frames may wait for the encoder: 1 is the latest alone."""
    choose: Callable[[RawT], bool] | None = None
    """Selects the raw frames to encode; None for all."""
    is_fresh: Callable[[RawT, float], bool] | None = None
    """Whether a raw frame can still be shown at a time of the media clock: then a requested key frame is made of the
    last one at once. Without it the source's next frame is awaited."""


class EncodedSource(Generic[RawT]):
    """`MediaSource` of encoded frames: while it is open, it reads `raw` and runs one encoder.

    The counters go on when it is closed and opened again. `forced` counts the requested key frames, by cause;
    `key_frames` all key frames, and each block of sound is one.
    """

    def __init__(self, raw: Fanout[RawT], encoding: Encoding[RawT], *, clock: MediaClock, bitrate: int) -> None:
        self.encoded = 0
        self.encoded_bytes = 0
        self.key_frames = 0
        self.forced = dict.fromkeys(KeyFrameCause, 0)
        self.bitrate = bitrate
        self._raw = raw
        self._encoding = encoding
        self._clock = clock
        self._budget = KeyFrameBudget()
        self._run: _Run[RawT] | None = None
        self._abandoned: list[EncoderThread[RawT]] = []
        self._dropped_before = 0
        self._encode_seconds_before = 0.0

    @property
    def dropped_input(self) -> int:
        """Raw frames that were lost because the encoder, or the loop that feeds it, was busy."""
        return self._dropped_before + (self._run.dropped if self._run else 0)

    @property
    def encode_seconds(self) -> float:
        """Time spent in the encoder, colour conversion included."""
        return self._encode_seconds_before + (self._run.thread.encode_seconds if self._run else 0.0)

    def request_key_frame(self, cause: KeyFrameCause) -> None:
        """Make a key frame as soon as the budget of `cause` allows: of the last frame while it is fresh."""
        self._budget.request(cause)
        run, now, is_fresh = self._run, self._clock.now(), self._encoding.is_fresh
        if run is None or run.last is None or is_fresh is None or not is_fresh(run.last, now):
            return
        taken = self._budget.take_cause(now)
        if taken is None and run.begun:
            return
        if taken is not None:
            self.forced[taken] += 1
        run.begun = True
        run.thread.hasten(run.last)

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s), now and whenever the encoder starts again."""
        self.bitrate = bitrate
        if self._run:
            self._run.thread.set_bitrate(bitrate)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedFrame]]:
        """Start the encoder and feed it; the iterator fails when the raw source or the encoder fails, or hangs.

        Raises:
            EncoderHung: `MAX_ABANDONED` encoders hang already.
        """
        encoding = self._encoding
        self._abandoned = [each for each in self._abandoned if each.is_abandoned]
        if len(self._abandoned) >= MAX_ABANDONED:
            raise EncoderHung(f"{MAX_ABANDONED} encoders hang: restart the adapter")
        thread = EncoderThread(
            partial(encoding.make_encoder, self.bitrate),
            depth=encoding.depth,
            name=f"{self._raw.name} {encoding.mime_type}",
        )
        async with self._raw.subscribe(encoding.depth) as raw, thread:
            # A viewer that joined while the previous encoder stopped may have asked that one.
            self._budget.restart()
            self._run = _Run(raw, thread)
            tasks = {
                asyncio.create_task(self._feed(self._run), name=f"feed {thread.name}"),
                asyncio.create_task(thread.watch(self._clock), name=f"watch {thread.name}"),
            }
            try:
                yield self._frames(thread)
            finally:
                for task in tasks:
                    task.cancel()
                await asyncio.wait(tasks)
                self._abandoned.append(thread)
                self._dropped_before, self._encode_seconds_before = self.dropped_input, self.encode_seconds
                self._run = None

    async def _feed(self, run: "_Run[RawT]") -> None:
        report = _DropReport(run.thread.name, self._clock.now())
        choose = self._encoding.choose
        try:
            while True:
                raw = await run.raw.get()
                now = self._clock.now()
                if choose is not None and not choose(raw):
                    continue
                if self._encoding.is_fresh is not None:
                    run.last = raw
                    if not run.begun and not self._budget.is_asked:
                        continue
                run.begun = True
                cause = self._budget.take_cause(now) if self._encoding.predicted else None
                if cause:
                    self.forced[cause] += 1
                run.thread.offer(raw, key_frame=cause is not None)
                report.update(now, run.dropped)
        except SourceEnded as end:
            run.thread.end_input(cast("Exception | None", end.__cause__))
        except Exception as error:
            run.thread.end_input(error)

    async def _frames(self, thread: EncoderThread[RawT]) -> AsyncIterator[EncodedFrame]:
        while (chunk := await thread.get()) is not None:
            frame = EncodedFrame(
                chunk.data,
                chunk.payloads,
                chunk.pts,
                self._encoding.clock_rate,
                chunk.keyframe,
                self.encoded,
                chunk.captured_at,
            )
            self.encoded += 1
            self.encoded_bytes += len(chunk.data)
            if chunk.keyframe:
                self.key_frames += 1
                self._budget.served()
            yield frame


@dataclass(slots=True)
class _Run(Generic[RawT]):
    """State of the source while it is open."""

    raw: Subscription[RawT]
    thread: EncoderThread[RawT]
    last: RawT | None = None
    """The source's last frame, where it may be encoded on request."""
    begun: bool = False
    """Whether a frame was encoded: before a key frame is requested, none is."""

    @property
    def dropped(self) -> int:
        return self.raw.dropped + self.thread.dropped


class _DropReport:
    """Log of losses as a rate: one line for each interval with losses."""

    def __init__(self, name: str, now: float) -> None:
        self._name = name
        self._since = now
        self._reported = 0

    def update(self, now: float, dropped: int) -> None:
        if now - self._since < _REPORT_INTERVAL:
            return
        if dropped > self._reported:
            _log.warning("%s: lost %d raw frames in %.0f s", self._name, dropped - self._reported, now - self._since)
        self._since, self._reported = now, dropped
