"""The receivers of a connected engine's messages: pictures, sound, and events."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.encoded_source import EngineEncoded, unannounced
from openrois_avatar.link.media import Audio, Doorbell, Encoded, Video
from openrois_avatar.link.messages import Command, Event, Hello, LinkError, RingPlace
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_source import MAX_AHEAD, EngineVideo, believed
from openrois_avatar.link.ring import Ring

_Item = TypeVar("_Item")

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Receivers:
    """The receivers of an engine's messages. The callbacks are called on the event loop and must not block."""

    clock: MediaClock
    video: EngineVideo
    encoded: EngineEncoded
    demand: PictureDemand
    on_audio: Callable[[RawAudio], None] | None = None
    on_event: Callable[[Event], None] | None = None
    on_hello: Callable[[Hello], None] | None = None
    """Called with the HELLO of a welcome engine, before anything else that it sends."""
    on_gone: Callable[[str], None] | None = None
    """Called with the reason when such an engine's connection has ended, before anything of another one."""


class Arrivals:
    """Passes the messages of one engine to the receivers, from `open` to `close`."""

    def __init__(self, receivers: Receivers) -> None:
        self._receivers = receivers
        self._ring: Ring | None = None
        self._hello: Hello | None = None
        self._encodes = False

    def open(self, hello: Hello) -> RingPlace | None:
        """Accept the engine; return its ring, if it asked for one and this machine provides one."""
        self._hello, self._encodes = hello, hello.encodes
        self._receivers.video.engine_arrived()
        if hello.ring:
            try:
                self._ring = Ring(hello.video)
            except LinkError as error:
                _log.warning("engine link: %s gets no ring: %s", hello.name, error)
        return None if self._ring is None else self._ring.place

    def announce(self, hello: Hello, ask: Callable[[Command], None]) -> None:
        """Connect the receivers after WELCOME; `ask` sends the engine a command."""
        if hello.demand:
            self._receivers.demand.engine_arrived(ask)
        self._receivers.encoded.engine_arrived(hello.video if hello.encodes else None, ask)
        notify(self._receivers.on_hello, hello)

    def close(self, reason: str) -> None:
        """Disconnect the receivers, for this reason."""
        if self._hello is not None:
            self._receivers.video.engine_gone()
            self._receivers.encoded.engine_gone()
            self._receivers.demand.engine_gone()
            notify(self._receivers.on_gone, reason)
        if self._ring is not None:
            self._ring.release()

    def handle_message(self, message: Video | Encoded | Doorbell | Audio | Event) -> None:
        """Pass a message to its receiver.

        Raises:
            LinkError: a wrong doorbell, or a picture that was not announced so, or cannot be passed on.
        """
        match message:
            case Doorbell() if not self._encodes:
                self._handle_doorbell(message)
            case Video() if not self._encodes:
                self._receivers.video.put(message)
            case Encoded() if self._encodes:
                self._receivers.encoded.put(message)
                self._receivers.video.count_received()
            case Video() | Encoded() | Doorbell():
                raise unannounced(self._encodes)
            case Audio():
                samples = np.frombuffer(message.samples, dtype="<i2").reshape(-1, message.channels)
                moment = believed(message.timestamp_ns, self._receivers.clock.now(), MAX_AHEAD)
                notify(self._receivers.on_audio, RawAudio(samples, moment))
            case _:
                notify(self._receivers.on_event, message)

    def _handle_doorbell(self, bell: Doorbell) -> None:
        ring = self._ring
        if ring is None:
            raise LinkError("RING: no ring was given; send VIDEO, or HELLO with `ring`")
        video = ring.picture(bell)
        if video is None:
            self._receivers.video.count_lost()
        else:
            self._receivers.video.put(video, lambda: ring.is_whole(bell))


def notify(callback: Callable[[_Item], None] | None, item: _Item) -> None:
    """Call a receiver if there is one; an exception is logged, and goes no further."""
    if callback is None:
        return
    try:
        callback(item)
    except Exception:
        _log.exception("engine link: a receiver failed")
