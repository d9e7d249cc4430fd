"""Thread of one encoder, and the two queues between it and the event loop."""

import asyncio
import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from types import TracebackType
from typing import Generic, NamedTuple, Self, TypeVar

from openrois_streaming.clock import MediaClock
from openrois_streaming.publish.encoder import Chunk, Encoder

RawT = TypeVar("RawT")

JOIN_TIMEOUT = 2.0
"""Seconds that closing waits for the thread to finish its frame."""

HANG = 3.0
"""Seconds at one frame after which an encoder counts as hung."""

# Checks that make a hang: a process that was stopped checks once when it continues, and its encoder gets its time.
_LOOKS = 6

# Encoded chunks that the loop has not fetched yet, above which the thread rests and its input loses frames instead.
_BACKLOG = 8

_log = logging.getLogger(__name__)


class EncoderHung(Exception):
    """Hang of an encoder: it does not return."""


class _Work(NamedTuple, Generic[RawT]):
    raw: RawT
    key_frame: bool
    again: bool = False
    """Whether the frame was encoded before, so that dropping it loses nothing."""


class EncoderThread(Generic[RawT]):
    """Encoder in a thread of its own, never in the loop's executor, whose threads name resolution needs too.

    An async context. Raw frames go in with `offer`, which never waits: of more than `depth` waiting frames the oldest
    is lost (counted in `dropped`; a key frame asked of it passes to the next one). Encoded chunks come out of `get`.

    `encode_seconds` is the time spent in the encoder so far, colour conversion included.
    """

    def __init__(
        self,
        make_encoder: Callable[[], Encoder[RawT]],
        *,
        depth: int,
        name: str,
        join_timeout: float = JOIN_TIMEOUT,
    ) -> None:
        self.dropped = 0
        self.encode_seconds = 0.0
        self._make_encoder = make_encoder
        self._depth = depth
        self._join_timeout = join_timeout
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        # Both threads use the following attributes, under this condition.
        self._changed = threading.Condition()
        self._waiting: deque[_Work[RawT]] = deque()
        self._unfetched = 0
        # Counts the frames that were begun and those that were done: while it is odd the encoder is at one.
        self._steps = 0
        self._hung = False
        self._stopping = False
        self._draining = False
        self._bitrate: int | None = None
        self._cause: Exception | None = None
        # The loop alone uses the following. The queue holds little more than _BACKLOG chunks: the thread then rests.
        self._chunks: asyncio.Queue[Chunk | None] = asyncio.Queue()
        self._finished = asyncio.Event()

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._thread.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify()
        if self._hung:
            return
        try:
            async with asyncio.timeout(self._join_timeout):
                await self._finished.wait()
        except TimeoutError:
            _log.error("%s: the encoder does not return; its thread is abandoned", self._thread.name)
        else:
            # The thread has nothing left to do but to return.
            self._thread.join(self._join_timeout)

    def offer(self, raw: RawT, *, key_frame: bool = False) -> None:
        """Hand over a raw frame, to be encoded as a key frame if `key_frame` is set."""
        with self._changed:
            if len(self._waiting) >= self._depth:
                left_out = self._waiting.popleft()
                key_frame |= left_out.key_frame
                self.dropped += not left_out.again
            self._waiting.append(_Work(raw, key_frame))
            self._changed.notify()

    def hasten(self, raw: RawT) -> None:
        """Encode a key frame as soon as the encoder can: of the newest frame that waits, or else of `raw` once more."""
        with self._changed:
            if self._waiting:
                self._waiting[-1] = self._waiting[-1]._replace(key_frame=True)
            else:
                self._waiting.append(_Work(raw, key_frame=True, again=True))
            self._changed.notify()

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s) from the next frame on."""
        with self._changed:
            self._bitrate = bitrate

    def end_input(self, cause: Exception | None) -> None:
        """End the input: `get` ends after the offered frames. `cause` is the failure of the input, if it has failed."""
        with self._changed:
            self._cause = cause
            self._draining = True
            self._changed.notify()

    async def get(self) -> Chunk | None:
        """Return the next chunk, or None at the end of the input.

        Raises:
            Exception: as the encoder raised, or as given to `end_input`. Not to be called again after that.
        """
        chunk = await self._chunks.get()
        if chunk is not None:
            with self._changed:
                self._unfetched -= 1
                self._changed.notify()
        elif self._cause is not None:
            raise self._cause
        return chunk

    async def watch(self, clock: MediaClock) -> None:
        """Abandon the encoder when it is at one frame for `HANG` seconds: `get` then raises `EncoderHung`.

        The thread cannot be ended; it ends when the encoder returns after all.
        """
        looks, seen = 0, -1
        while looks < _LOOKS:
            await clock.sleep_until(clock.now() + HANG / _LOOKS)
            steps = self._steps
            looks = looks + 1 if steps % 2 and steps == seen else 0
            seen = steps
        _log.error("%s: the encoder is at one frame for %.0f s; its thread is abandoned", self._thread.name, HANG)
        self._hung = True
        self._finish(EncoderHung(f"the encoder does not return after {HANG:.0f} s"))

    @property
    def is_abandoned(self) -> bool:
        """Whether the encoder was abandoned and has not returned since."""
        return self._hung and self._thread.is_alive()

    @property
    def name(self) -> str:
        """The name of the thread."""
        return self._thread.name

    def _run(self) -> None:
        error: Exception | None = None
        try:
            self._steps += 1
            encoder = self._make_encoder()
            self._steps += 1
            while (work := self._next(encoder)) is not None:
                self._steps += 1
                started = time.perf_counter()
                chunks = encoder.encode(work.raw, key_frame=work.key_frame)
                self.encode_seconds += time.perf_counter() - started
                self._steps += 1
                with self._changed:
                    self._unfetched += len(chunks)
                self._call_in_loop(partial(self._deliver, chunks))
        except Exception as failure:
            error = failure
        finally:
            self._call_in_loop(partial(self._finish, error))

    def _next(self, encoder: Encoder[RawT]) -> _Work[RawT] | None:
        with self._changed:
            self._changed.wait_for(self._has_news)
            if self._stopping or not self._waiting:
                return None
            if self._bitrate is not None:
                encoder.set_bitrate(self._bitrate)
                self._bitrate = None
            return self._waiting.popleft()

    def _has_news(self) -> bool:
        if self._waiting:
            return self._stopping or self._unfetched < _BACKLOG
        return self._stopping or self._draining

    def _call_in_loop(self, news: Callable[[], None]) -> None:
        # A loop that was closed without closing this context has no reader left.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(news)

    def _deliver(self, chunks: Sequence[Chunk]) -> None:
        for chunk in chunks:
            self._chunks.put_nowait(chunk)

    def _finish(self, error: Exception | None) -> None:
        self._finished.set()
        self._cause = error or self._cause
        self._chunks.put_nowait(None)
