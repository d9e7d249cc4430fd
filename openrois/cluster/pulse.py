"""The signs of life of a gateway: its own, and what it makes of those of others."""

import asyncio
import logging
import secrets
import time
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final

from openrois.aio.listeners import Listeners
from openrois.cluster.connection import NatsConnection
from openrois.cluster.frames import MAX_BEAT, Beat, FrameFault, parse_said
from openrois.cluster.presence import BEAT_INTERVAL, SILENCE, Presence, Present
from openrois.cluster.subjects import Subjects
from openrois.version import __version__

__all__ = ["Pulse"]

_log = logging.getLogger(__name__)

_NO_LINK: Final = "0" * 16


class Pulse:
    """Beats while there is a connection to NATS, and listens to itself: what does not come back does not reach others.

    Args:
        subjects: where signs of life go.
        gateway_id: of this gateway.
        attributes: what it tells all others.
        clock: monotonic seconds.
        sleep: waits for some seconds.

    Attributes:
        presence: which gateways are there.
        is_behind: whether what comes was said while this process stood still.
        listeners: called with the gateways that are there when that changes.
        on_beat: called with the time whenever this gateway has beaten.
        on_gone: called when another gateway's connection has gone.
        on_pause: called when this process stood still for so long that all others have given it up.
    """

    def __init__(
        self,
        subjects: Subjects,
        gateway_id: str,
        attributes: Mapping[str, Any],
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._subjects = subjects
        self._gateway_id = gateway_id
        self._subject = subjects.beat(gateway_id)
        self._attributes = attributes
        self._clock = clock
        self._sleep = sleep
        self._instance = secrets.token_hex(8)
        self._connection: NatsConnection | None = None
        self._link = _NO_LINK
        self._beaten = self._echoed = clock()
        self._number = 0
        self._caught_up_by = 0
        self._has_namesake = False
        self.presence = Presence(clock)
        self.is_behind = False
        self.listeners: Listeners[Mapping[str, Present]] = Listeners()
        self.on_beat: Callable[[float], None] = lambda _now: None
        self.on_gone: Callable[[], None] = lambda: None
        self.on_pause: Callable[[], None] = lambda: None
        self._message()

    def announce(self, attributes: Mapping[str, Any]) -> None:
        """Tell all others these attributes from now on.

        Raises:
            ValueError: they are too much.
        """
        before, self._attributes = self._attributes, attributes
        try:
            self._message()
        except ValueError:
            self._attributes = before
            raise
        self._publish()

    def begin(self, connection: NatsConnection, link: str) -> None:
        """Beat over a connection from now on."""
        self._connection, self._link = connection, link
        self._beaten = self._echoed = self._clock()
        connection.subscribe(self._subjects.beats, self._handle_beat)
        self._publish()

    def lose_connection(self) -> None:
        """Note that there is no connection: no gateway is there."""
        self._connection, self._link = None, _NO_LINK
        self.is_behind = False
        before = self.presence.present
        self.presence.clear()
        self._notify_if_changed(before)

    def leave(self) -> None:
        """Tell all others that this gateway will be gone at once."""
        if self._connection is not None:
            self._connection.publish(self._subject, self._message(leaving=True))

    def _message(self, *, leaving: bool = False) -> bytes:
        data = (
            Beat(
                gateway=self._gateway_id,
                instance=self._instance,
                link=self._link,
                version=__version__,
                number=self._number,
                attributes=dict(self._attributes),
                leaving=leaving,
            )
            .model_dump_json()
            .encode()
        )
        if len(data) > MAX_BEAT:
            raise ValueError(f"the attributes of a gateway are too much: {len(data)} bytes, of at most {MAX_BEAT}")
        return data

    def _publish(self) -> None:
        if self._connection is not None:
            self._number += 1
            self._connection.publish(self._subject, self._message())

    def _handle_beat(self, _subject: bytes, _headers: bytes, payload: bytes) -> None:
        self.notice_pause()
        try:
            beat = parse_said(Beat, payload, MAX_BEAT)
        except FrameFault as fault:
            _log.warning("a gateway is not understood: %s", fault)
            return
        if beat.link == self._link:
            self._echoed = self._clock()
            self.is_behind = self.is_behind and beat.number < self._caught_up_by
        elif beat.gateway == self._gateway_id and beat.instance != self._instance and not self._has_namesake:
            self._has_namesake = True
            _log.error("another process is gateway %r too: give each an id of its own", self._gateway_id)
        before = self.presence.present
        if self.presence.handle_beat(beat):
            self.on_gone()
        self._notify_if_changed(before)

    def _notify_if_changed(self, before: Mapping[str, Present]) -> None:
        if self.presence.present is not before:
            self.listeners.notify_all(self.presence.present)

    async def run(self) -> None:
        """Beat, and notice which signs of life fail to come, for ever."""
        while True:
            self.notice_pause()
            now = self._clock()
            if now >= self._beaten + BEAT_INTERVAL:
                self._beaten = now
                self._publish()
                self.on_beat(now)
            self._expire(now)
            due = min(self._beaten + BEAT_INTERVAL, self.presence.next_expiry, self._echoed + SILENCE)
            await self._sleep(max(0.0, due - self._clock()))

    def _expire(self, now: float) -> None:
        if now >= self._echoed + SILENCE:
            self._echoed = now
            if self._connection is not None:
                self._connection.abort("NATS is silent")
        before = self.presence.present
        if self.presence.expire():
            self.on_gone()
            self._notify_if_changed(before)

    def notice_pause(self) -> None:
        """Note, before anything is read, whether this process stood still for so long that others have given it up.

        What they said before they did waits to be read: it is old, and no more to be acted upon.
        """
        now = self._clock()
        if now < self._beaten + SILENCE:
            return
        if self._connection is not None:
            _log.warning("this process stood still for %.1f s: streams to other gateways end", now - self._beaten)
        # Those that it did not hear may have beaten all the while; what they said before this comes before it, too.
        self._beaten, self._echoed = now, now
        self._publish()
        self._caught_up_by, self.is_behind = self._number, self._connection is not None
        self.presence.excuse()
        self.on_pause()
