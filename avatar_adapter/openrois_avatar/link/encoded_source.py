"""The encoded pictures of an engine as a source of the media plane, and requests to its encoder."""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.rtp.h264_units import NotPassable, access_unit
from openrois_streaming.source.source import EncodedVideo

from openrois_avatar.link.media import Encoded
from openrois_avatar.link.messages import Bitrate, Command, KeyFrame, LinkError, VideoShape
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_source import Timestamps

MAX_WAITING: Final = 32
"""Pictures that may wait for the reader; one more, and all are lost up to the next key frame."""

_log = logging.getLogger(__name__)


class EngineEncoded:
    """The encoded pictures of the connected engine, as an `EncodingSource`.

    Without such an engine there are no pictures, and requests go to the next one. While it is not open there is no
    demand, and pictures that arrive all the same are checked and dropped. `dropped` counts those that were lost
    because they were not read.

    Args:
        clock: the media clock.
        demand: counts this source as a consumer while it is open.
    """

    def __init__(self, clock: MediaClock, demand: PictureDemand) -> None:
        self.announced: VideoShape | None = None
        """The announced pictures of the last connected engine, if it encodes them itself."""
        self.dropped = 0
        self._demand = demand
        self._timestamps = Timestamps(clock)
        self._ask: Callable[[Command], None] | None = None
        self._bitrate: int | None = None
        self._first_sequence = 0
        self._next_sequence = 0
        self._waiting: deque[EncodedVideo] = deque()
        self._arrived = asyncio.Event()
        self._open = False
        self._whole = True
        """Whether no picture was lost since the last key frame."""

    def engine_arrived(self, shape: VideoShape | None, ask: Callable[[Command], None]) -> None:
        """Note a connected engine and the shape of its encoded pictures, None if it does not encode them."""
        self.announced = shape
        # One number is left out: the pictures of this engine cannot be decoded after those of the last one.
        self._first_sequence = self._next_sequence = self._next_sequence + 1
        self._ask = ask if shape is not None else None
        if self._open:
            if self._bitrate is not None:
                self._send_command(Bitrate(self._bitrate))
            self._send_command(KeyFrame())

    def engine_gone(self) -> None:
        """Note that the engine is disconnected."""
        self._ask = None

    def put(self, picture: Encoded) -> None:
        """Add a picture from the link; never waits.

        Raises:
            LinkError: the picture cannot be passed on, or does not match its header.
        """
        data = bytes(picture.data)
        check_encoded(picture)
        sequence = self._first_sequence + picture.sequence
        self._next_sequence = sequence + 1
        moment = self._timestamps.captured_at(picture.timestamp_ns)
        if not self._open:
            return
        if not self._demand.is_stale(moment):
            size = picture.width, picture.height
            self._queue(EncodedVideo(data, picture.keyframe, *size, sequence, moment))
        elif picture.keyframe:
            # It may be the requested one, without which no later picture could be decoded.
            self.request_key_frame()

    def _queue(self, picture: EncodedVideo) -> None:
        if len(self._waiting) >= MAX_WAITING:
            self.dropped += len(self._waiting)
            self._waiting.clear()
            self._whole = False
            self.request_key_frame()
        self._whole = self._whole or picture.keyframe
        if not self._whole:
            self.dropped += 1
            return
        self._waiting.append(picture)
        self._arrived.set()

    def request_key_frame(self) -> None:
        """Request a key frame of the engine."""
        self._send_command(KeyFrame())

    def set_bitrate(self, bitrate: int) -> None:
        """Request a bit rate of the engine, in bit/s."""
        self._bitrate = bitrate
        self._send_command(Bitrate(bitrate))

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedVideo]]:
        """Read the pictures that are drawn from now on."""
        self._open, self._whole = True, True
        try:
            with self._demand.wanted():
                yield self._pictures()
        finally:
            self._open = False
            self._waiting.clear()

    async def _pictures(self) -> AsyncIterator[EncodedVideo]:
        while True:
            while self._waiting:
                yield self._waiting.popleft()
            self._arrived.clear()
            await self._arrived.wait()

    def _send_command(self, command: Command) -> None:
        if self._ask is None:
            return
        try:
            self._ask(command)
        except LinkError as error:
            _log.debug("a request was not sent to the game engine: %s", error)


def check_encoded(picture: Encoded) -> None:
    """Raise `LinkError` unless the picture can be passed on, and matches its header."""
    try:
        found = access_unit(picture.data)
    except NotPassable as error:
        raise LinkError(f"VIDEO: {error}; send H.264 constrained baseline in Annex B form") from error
    if found.keyframe is not picture.keyframe:
        raise LinkError(
            "VIDEO: the flag of a key frame and the picture differ; set it for IDR pictures, and for no others"
        )
    if found.size is not None and found.size != (picture.width, picture.height):
        width, height = found.size
        raise LinkError(
            f"VIDEO: its SPS says {width}x{height}, not {picture.width}x{picture.height}; send the size of the SPS"
        )


def unannounced(encodes: bool) -> LinkError:
    """Return the error for a raw picture of an engine that announced encoded ones, or the other way round."""
    announced, came = ("h264", "raw") if encodes else ("raw pictures", "h264")
    return LinkError(f"VIDEO: HELLO announced {announced}, and this is {came}; send the announced `format`")
