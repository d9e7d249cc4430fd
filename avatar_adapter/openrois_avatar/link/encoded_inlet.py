"""Where the pictures of an engine that encodes them itself enter the media plane, and what its encoder is asked for."""

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

from openrois_avatar.link.demand import PictureDemand
from openrois_avatar.link.inlet import Timestamps
from openrois_avatar.link.media import Encoded
from openrois_avatar.link.messages import Bitrate, Command, KeyFrame, LinkError, VideoShape

MAX_WAITING: Final = 32
"""Pictures that wait for who reads them; one more, and all are lost up to the next key frame."""

_log = logging.getLogger(__name__)


class EngineEncoded:
    """The encoded pictures of whichever engine is connected, as an `EncodingSource`.

    While no such engine is connected there are no pictures, and what is asked is told to the next one. While it is not
    open no pictures are wanted, and those that come all the same are looked at and forgotten. `dropped` counts those
    that were lost because they were not read.

    Args:
        clock: the media clock.
        demand: what is told that pictures are wanted.
    """

    def __init__(self, clock: MediaClock, demand: PictureDemand) -> None:
        self.announced: VideoShape | None = None
        """The pictures of the engine that was connected last, if it encodes them itself."""
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
        """Whether nothing was lost since the last key frame."""

    def begin(self, shape: VideoShape | None, ask: Callable[[Command], None]) -> None:
        """An engine has come, whose pictures are of this shape if it encodes them; `ask` sends it a command."""
        self.announced = shape
        # One number is left out: what follows cannot be decoded after what was before.
        self._first_sequence = self._next_sequence = self._next_sequence + 1
        self._ask = ask if shape is not None else None
        if self._open:
            if self._bitrate is not None:
                self._tell(Bitrate(self._bitrate))
            self._tell(KeyFrame())

    def end(self) -> None:
        """The engine has gone."""
        self._ask = None

    def put(self, picture: Encoded) -> None:
        """Take a picture from the link; never waits.

        Raises:
            LinkError: it is not a picture that can be passed on, or not as it claims to be.
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
            # It may be the one that was asked for, and nothing that follows could be decoded.
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
        """Ask the engine for a key frame."""
        self._tell(KeyFrame())

    def set_bitrate(self, bitrate: int) -> None:
        """Ask the engine to aim at `bitrate` (bit/s)."""
        self._bitrate = bitrate
        self._tell(Bitrate(bitrate))

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

    def _tell(self, command: Command) -> None:
        if self._ask is None:
            return
        try:
            self._ask(command)
        except LinkError as error:
            _log.debug("not asked of the game engine: %s", error)


def check_encoded(picture: Encoded) -> None:
    """Raise `LinkError` unless it is a picture that can be passed on, and is as it claims to be."""
    try:
        found = access_unit(picture.data)
    except NotPassable as error:
        raise LinkError(f"VIDEO: {error}") from error
    if found.keyframe is not picture.keyframe:
        raise LinkError("VIDEO: the flag of a key frame and what is in the picture differ")
    if found.size is not None and found.size != (picture.width, picture.height):
        width, height = found.size
        raise LinkError(f"VIDEO: its SPS says {width}x{height}, not {picture.width}x{picture.height}")
