"""Media that an application sends in one m-section, as aiortc's sender reads it."""

import asyncio
from collections import deque
from fractions import Fraction
from typing import Final

import av
from aiortc import MediaStreamTrack
from aiortc.mediastreams import MediaStreamError

from openrois_streaming.source.av_frames import VIDEO_CLOCK_RATE, picture_frame, sound_frame
from openrois_streaming.source.source import RawAudio, RawVideo

WAITING_LIMIT: Final = {"video": 1, "audio": 20}
"""Frames that may wait for the encoder; the oldest makes room for the newest."""


class OutgoingTrack(MediaStreamTrack):
    """Track that is fed with raw frames; the encoder is idle while nothing is put into it.

    It lives as long as its m-section: aiortc's sender ends for good with its first track, and replaces one only when
    that has given a frame.
    """

    def __init__(self, kind: str) -> None:
        super().__init__()
        self.kind = kind
        self._frames: deque[RawVideo | RawAudio] = deque(maxlen=WAITING_LIMIT[kind])
        self._news = asyncio.Event()
        self._origin: float | None = None
        self._samples = 0

    def put(self, frame: RawVideo | RawAudio) -> None:
        """Send a frame, unless the encoder is too slow for it; to be called in the event loop."""
        self._frames.append(frame)
        self._news.set()

    def clear(self) -> None:
        """Drop what waits for the encoder."""
        self._frames.clear()

    def stop(self) -> None:
        """End the track with its peer connection."""
        super().stop()
        self._news.set()

    async def recv(self) -> av.VideoFrame | av.AudioFrame:
        """Return the next frame, for aiortc.

        Raises:
            MediaStreamError: the peer connection is closed.
        """
        while not self._frames:
            if self.readyState != "live":
                raise MediaStreamError
            self._news.clear()
            await self._news.wait()
        frame = self._frames.popleft()
        return self._picture(frame) if isinstance(frame, RawVideo) else self._sound(frame)

    def _picture(self, raw: RawVideo) -> av.VideoFrame:
        if self._origin is None:
            self._origin = raw.captured_at
        frame = picture_frame(raw)
        frame.pts = round((raw.captured_at - self._origin) * VIDEO_CLOCK_RATE)
        frame.time_base = Fraction(1, VIDEO_CLOCK_RATE)
        return frame

    def _sound(self, raw: RawAudio) -> av.AudioFrame:
        frame = sound_frame(raw)
        # aiortc's encoder takes timestamps without a gap only.
        frame.pts = self._samples
        self._samples += len(raw.samples)
        return frame
