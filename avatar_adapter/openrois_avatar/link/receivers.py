"""Where what a connected engine sends goes: its pictures, whichever way they come, its sound, and its events."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.demand import PictureDemand
from openrois_avatar.link.encoded_inlet import EngineEncoded
from openrois_avatar.link.inlet import MAX_AHEAD, EngineVideo, believed
from openrois_avatar.link.media import Audio, Doorbell, Encoded, Video
from openrois_avatar.link.messages import Command, Event, Hello, LinkError, RingPlace
from openrois_avatar.link.ring import Ring

_Item = TypeVar("_Item")

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Receivers:
    """Where what an engine sends goes. The callbacks are called on the event loop and must not block."""

    clock: MediaClock
    video: EngineVideo
    encoded: EngineEncoded
    demand: PictureDemand
    on_audio: Callable[[RawAudio], None] | None = None
    on_event: Callable[[Event], None] | None = None
    on_hello: Callable[[Hello], None] | None = None
    """Called with the greeting of an engine that is welcome, before anything else that it sends."""
    on_gone: Callable[[str], None] | None = None
    """Called with the reason when such an engine's connection is over, before anything that another one sends."""


class Arrivals:
    """What arrives from one engine, from its greeting on; `end` it with the connection."""

    def __init__(self, receivers: Receivers) -> None:
        self._receivers = receivers
        self._ring: Ring | None = None
        self._hello: Hello | None = None
        self._encodes = False

    def begin(self, hello: Hello) -> RingPlace | None:
        """The engine is welcome; gives the ring that it gets, if it wants one and there is one to be had."""
        self._hello, self._encodes = hello, hello.encodes
        self._receivers.video.begin()
        if hello.ring:
            try:
                self._ring = Ring(hello.video)
            except LinkError as error:
                _log.warning("engine link: %s gets no ring: %s", hello.name, error)
        return None if self._ring is None else self._ring.place

    def announce(self, hello: Hello, ask: Callable[[Command], None]) -> None:
        """The engine has been welcomed: `ask` sends it a command."""
        if hello.demand:
            self._receivers.demand.begin(ask)
        self._receivers.encoded.begin(hello.video if hello.encodes else None, ask)
        tell(self._receivers.on_hello, hello)

    def end(self, reason: str) -> None:
        """Nothing more arrives, for this reason."""
        if self._hello is not None:
            self._receivers.video.end()
            self._receivers.encoded.end()
            self._receivers.demand.end()
            tell(self._receivers.on_gone, reason)
        if self._ring is not None:
            self._ring.release()

    def take(self, message: Video | Encoded | Doorbell | Audio | Event) -> None:
        """Hand on what has arrived.

        Raises:
            LinkError: a doorbell is not true, a picture is of a kind that was not announced, or cannot be passed on.
        """
        match message:
            case Doorbell() if not self._encodes:
                self._take_from_ring(message)
            case Video() if not self._encodes:
                self._receivers.video.put(message)
            case Encoded() if self._encodes:
                self._receivers.encoded.put(message)
                self._receivers.video.passed_by()
            case Video() | Encoded() | Doorbell():
                raise LinkError(f"VIDEO: HELLO announced {'h264' if self._encodes else 'no h264'}")
            case Audio():
                samples = np.frombuffer(message.samples, dtype="<i2").reshape(-1, message.channels)
                moment = believed(message.timestamp_ns, self._receivers.clock.now(), MAX_AHEAD)
                tell(self._receivers.on_audio, RawAudio(samples, moment))
            case _:
                tell(self._receivers.on_event, message)

    def _take_from_ring(self, bell: Doorbell) -> None:
        ring = self._ring
        if ring is None:
            raise LinkError("RING: no ring was given")
        video = ring.picture(bell)
        if video is None:
            self._receivers.video.lost()
        else:
            self._receivers.video.put(video, lambda: ring.is_whole(bell))


def tell(callback: Callable[[_Item], None] | None, item: _Item) -> None:
    """Call a receiver if there is one; if it fails that is logged, and whoever told it goes on."""
    if callback is None:
        return
    try:
        callback(item)
    except Exception:
        _log.exception("engine link: a receiver failed")
