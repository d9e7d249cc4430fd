"""Camera of an application as a source: decoded in a thread while the source is open."""

import logging
import threading
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Generic, NamedTuple, TypeAlias, TypeVar

import av

from openrois_streaming.receive.decoders import UndecodablePicture, VideoDecoder, planes_of
from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.receive.worker import Handover, Worker
from openrois_streaming.source.source import ReceivedVideo

WAITING_LIMIT = 16
"""Pictures that wait to be decoded. If there are more the decoder is too slow, and goes on with a key frame."""

_log = logging.getLogger(__name__)


class EncodedPicture(NamedTuple):
    """Picture that can be decoded after the one before it, or by itself if it is a key frame."""

    data: bytes
    key_frame: bool
    captured: CaptureTime


Picture = TypeVar("Picture")

MakePicture: TypeAlias = Callable[[av.VideoFrame, int, CaptureTime], Picture]
"""Makes what a reader gets, of a frame in I420 of limited range, its number, and its capture time; in any thread."""


def raw_picture(frame: av.VideoFrame, sequence: int, captured: CaptureTime) -> ReceivedVideo:
    """Return a decoded frame as a raw picture."""
    return ReceivedVideo(planes_of(frame), "i420", frame.width, frame.height, sequence, *captured)


class VideoSource(Generic[Picture]):
    """`MediaSource` of pictures, as `make` makes them. A reader that is slower than the sender gets the newest picture.

    `on_open` is called when it is opened: pictures are to be offered from then on, beginning with a key frame.
    `on_lost` is called, from any thread, when the next offered picture has to be a key frame. `on_close` is called when
    it is closed.
    """

    def __init__(
        self,
        on_open: Callable[[], None],
        on_lost: Callable[[], None],
        on_close: Callable[[], None],
        make: MakePicture[Picture],
    ) -> None:
        self.make = make
        self.mime_type = ""
        """Media type of the pictures that are offered next."""
        self.decoded = 0
        self.dropped = 0
        """Pictures that were not decoded, or not read in time."""
        self._on_open, self._on_lost, self._on_close = on_open, on_lost, on_close
        self._decoding: _Decoding[Picture] | None = None
        self._ended = False

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[Picture]]:
        """Decode while the context lasts; the iterator ends when the sender is gone for good.

        Raises:
            RuntimeError: it is open already.
        """
        if self._decoding is not None:
            raise RuntimeError("the source is open already: close it first")
        pictures = Handover[Picture](1)
        decoding = self._decoding = _Decoding(self, pictures)
        try:
            async with Worker("decode video", decoding.run, decoding.stop, pictures.end_input):
                if self._ended:
                    pictures.end_input()
                self._on_open()
                yield pictures
        finally:
            self._decoding = None
            self.dropped += pictures.lost
            self._on_close()

    def offer(self, picture: EncodedPicture) -> None:
        """Offer a picture, which is decoded while the source is open."""
        if self._decoding is not None and not self._decoding.offer(picture, self.mime_type):
            self._on_lost()

    def end_input(self) -> None:
        """End the input: no more pictures will be offered."""
        self._ended = True
        if self._decoding is not None:
            self._decoding.pictures.end_input()

    def lost(self) -> None:
        """Request a key frame; callable from any thread."""
        self._on_lost()


class _Decoding(Generic[Picture]):
    """One opening of the source: its thread, and the pictures that wait for it."""

    def __init__(self, source: VideoSource[Picture], pictures: Handover[Picture]) -> None:
        self.pictures = pictures
        self._source = source
        self._sequence = 0
        self._decoder: VideoDecoder | None = None
        self._decodes = ""
        # Both threads use the following attributes, under this condition.
        self._changed = threading.Condition()
        self._waiting: deque[tuple[EncodedPicture, str]] = deque()
        self._needs_key_frame = True
        self._stopping = False

    def offer(self, picture: EncodedPicture, mime_type: str) -> bool:
        """Queue a picture; False if the queue overflows, so that a key frame is needed."""
        with self._changed:
            if self._needs_key_frame and not picture.key_frame:
                self._source.dropped += 1
                return True
            if len(self._waiting) >= WAITING_LIMIT:
                self._source.dropped += len(self._waiting) + 1
                self._waiting.clear()
                self._needs_key_frame = True
                return False
            self._needs_key_frame = False
            self._waiting.append((picture, mime_type))
            self._changed.notify()
            return True

    def stop(self) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify()

    def run(self) -> None:
        while (work := self._next()) is not None:
            try:
                self._decode(*work)
            except UndecodablePicture as error:
                self._fail(error)

    def _next(self) -> tuple[EncodedPicture, str] | None:
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._stopping)
            return None if self._stopping else self._waiting.popleft()

    def _decode(self, picture: EncodedPicture, mime_type: str) -> None:
        if self._decoder is None or mime_type != self._decodes:
            self._decoder, self._decodes = VideoDecoder(mime_type), mime_type
        for frame in self._decoder.decode(picture.data):
            self._source.decoded += 1
            self.pictures.put(self._source.make(frame, self._sequence, picture.captured))
            self._sequence += 1

    def _fail(self, error: UndecodablePicture) -> None:
        _log.debug("a picture cannot be decoded: %s", error)
        with self._changed:
            self._source.dropped += 1 + len(self._waiting)
            self._waiting.clear()
            self._needs_key_frame = True
        self._source.lost()
