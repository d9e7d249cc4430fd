"""What a peer connection reads: a track of encoded frames whose source can be changed under it.

aiortc ends a sender for good when `recv()` raises, and swaps a track only after the old one's `recv()` returned. So
one track lives as long as its m-section: it never raises, and sources and gates are changed inside.
"""

import asyncio
from collections.abc import Callable
from typing import Any

import av
from aiortc import MediaStreamTrack

from openrois_streaming.encoded import EncodedFrame

REPEAT_REQUEST = 1.0
"""Seconds of media after which a key frame is asked for again when none has come."""


class ReferenceChain:
    """Which frames of a rendition can be decoded after what was sent before. Pure.

    Pictures are predicted from the ones before them, so nothing is of use after a gap until the next key frame.
    """

    __slots__ = ("_asked", "_next", "_predicted")

    def __init__(self, kind: str) -> None:
        self._predicted = kind == "video"
        self._next: int | None = None
        self._asked: float | None = None

    def admits(self, frame: EncodedFrame) -> bool:
        """Whether `frame` can be decoded by somebody who decoded what was admitted before."""
        if self._predicted and not frame.keyframe and frame.sequence != self._next:
            self._next = None
            return False
        self._next = frame.sequence + 1
        self._asked = None
        return True

    def should_ask(self, frame: EncodedFrame) -> bool:
        """After `frame` was not admitted: whether to ask for a key frame now. Once, and then once in a while."""
        due = self._asked is None or frame.captured_at - self._asked >= REPEAT_REQUEST
        if due:
            self._asked = frame.captured_at
        return due


class PacketTrack(MediaStreamTrack):
    """A track of `kind` "video" or "audio" that hands encoded frames to one sender.

    It holds one frame; `deliver` waits until that is taken, so that what a slow sender cannot take is lost in the
    bounded queue before it, which knows how. `on_sent` is called with each frame that the sender takes.
    """

    def __init__(self, kind: str, on_sent: Callable[[EncodedFrame], None]) -> None:
        super().__init__()
        self.kind = kind
        self._on_sent = on_sent
        self._frame: EncodedFrame | None = None
        self._filled = asyncio.Event()
        self._emptied = asyncio.Event()
        self._emptied.set()

    async def deliver(self, frame: EncodedFrame) -> None:
        """Hand over the next frame of the current source; returns when there is room for another."""
        await self._emptied.wait()
        self._frame = frame
        self._emptied.clear()
        self._filled.set()

    def clear(self) -> None:
        """Forget the frame that was not taken yet: its source is no longer the current one."""
        self._take()

    async def recv(self) -> "av.Packet[Any]":
        """Wait for the next frame, however long that takes."""
        while True:
            await self._filled.wait()
            frame = self._take()
            if frame is not None:
                self._on_sent(frame)
                return frame.to_packet()

    def _take(self) -> EncodedFrame | None:
        frame, self._frame = self._frame, None
        self._filled.clear()
        self._emptied.set()
        return frame
