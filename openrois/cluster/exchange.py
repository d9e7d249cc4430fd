"""All streams of a gateway over one connection to NATS: they begin after it, and end with it."""

import asyncio
import logging
import secrets
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.cluster.connection import NatsConnection
from openrois.cluster.dial_failed import LOST, DialFailed
from openrois.cluster.flow import MAX_MESSAGE, WINDOW, Receiving
from openrois.cluster.frames import (
    CUT_FRAME,
    MAX_GREETING,
    PROTOCOL,
    Accept,
    Dial,
    FrameFault,
    Kind,
    pack_close,
    pack_frame,
    parse_said,
)
from openrois.cluster.pulse import Pulse
from openrois.cluster.stream import NatsStream, sender_of
from openrois.cluster.subjects import Subjects
from openrois.transport.stream import StreamClosed

__all__ = ["Exchange", "Handler"]

_log = logging.getLogger(__name__)

DIAL_TIMEOUT: Final = 0.9
"""Seconds that another gateway may take to accept or refuse a stream."""

MARK_INTERVAL: Final = 5.0
"""Seconds after which an idle stream shows that it is there: the other side may have lost it unnoticed."""

_GOING_AWAY: Final = 1001
_WRONG_VERSION: Final = 1002
_FAILED: Final = 1011
_TRY_LATER: Final = 1013
_LEAVING: Final = "the gateway is leaving"

Handler = Callable[[NatsStream, Mapping[str, Any]], Awaitable[None]]


class Exchange:
    """The streams over one connection.

    Args:
        connection: it.
        subjects: where frames go.
        gateway_id: of this gateway.
        pulse: notices which other gateways are gone.
        tasks: the parent of what handles streams.
        max_streams: at a time; more are refused.
        max_message: bytes of one incoming message.
        on_gap: called when a stream has ended because a frame was missing.

    Attributes:
        link: the token of the connection, another one each time: what was on its way to streams of a former connection
            comes to none.
    """

    def __init__(
        self,
        connection: NatsConnection,
        subjects: Subjects,
        gateway_id: str,
        pulse: Pulse,
        tasks: TaskScope,
        *,
        max_streams: int,
        max_message: int = MAX_MESSAGE,
        on_gap: Callable[[], None] = lambda: None,
    ) -> None:
        self.link = secrets.token_hex(8)
        self._connection = connection
        self._subjects = subjects
        self._gateway_id = gateway_id
        self._pulse = pulse
        self._tasks = tasks
        self._max_streams = max_streams
        self._max_message = max_message
        self._on_gap = on_gap
        self._handler: Handler | None = None
        self._streams: dict[int, NatsStream] = {}
        self._next_number = 0
        everything = subjects.streams(self.link)
        self._before_number = len(everything) - 1
        connection.subscribe(everything, self._handle_frame)

    def __len__(self) -> int:
        return len(self._streams)

    def count_streams(self) -> Counter[str]:
        """Return how many streams there are with each gateway."""
        return Counter(stream.gateway_id for stream in self._streams.values())

    def listen(self, handler: Handler) -> None:
        """Let other gateways dial this one."""
        self._handler = handler
        # Of two processes with the same id by mistake one is dialled.
        self._connection.subscribe(self._subjects.dial(self._gateway_id), self._handle_dial, group="gateway")

    async def dial(self, gateway_id: str, hello: Mapping[str, Any]) -> NatsStream:
        """Return a stream to another gateway.

        Raises:
            DialFailed: there is none; within a second.
            ValueError: the id cannot be one, or what is asserted is too long.
        """
        subject = self._subjects.dial(gateway_id)
        if len(self._streams) >= self._max_streams:
            raise DialFailed(gateway_id, LOST, f"this gateway has {self._max_streams} streams already")
        stream = self._new_stream(gateway_id)
        try:
            said = Dial(**stream.address.model_dump(), gateway=self._gateway_id, hello=dict(hello))
            data = said.model_dump_json().encode()
            if len(data) > MAX_GREETING:
                raise ValueError(f"what is asserted is too long: {len(data)} bytes, of at most {MAX_GREETING}")
            self._connection.publish(subject, data, reply=self._subjects.stream(self.link, stream.number))
            async with asyncio.timeout(DIAL_TIMEOUT):
                await stream.opened.wait()
        except TimeoutError:
            stream.lose("no answer")
            raise DialFailed(gateway_id, LOST, f"it does not answer within {DIAL_TIMEOUT:g} s") from None
        except BaseException:
            stream.lose("given up")
            raise
        if stream.closed is not None and not stream.other_link:
            raise DialFailed(gateway_id, stream.closed.code, stream.closed.reason)
        return stream

    def _new_stream(self, gateway_id: str, said: Dial | None = None) -> NatsStream:
        number, self._next_number = self._next_number, self._next_number + 1
        address = Accept(link=self.link, stream=number, version=PROTOCOL, window=WINDOW)
        receiving = Receiving(WINDOW, self._max_message)
        stream = NatsStream(
            self._connection, self._subjects, address, receiving, self._remove, gateway_id=gateway_id, dialled_by=said
        )
        self._streams[number] = stream
        return stream

    def _remove(self, stream: NatsStream) -> None:
        self._streams.pop(stream.number, None)
        if stream.has_gap:
            self._on_gap()

    # What comes

    def _handle_frame(self, subject: bytes, headers: bytes, payload: bytes) -> None:
        self._pulse.notice_pause()
        number = subject[self._before_number :]
        stream = self._streams.get(int(number)) if number.isdigit() else None
        if stream is None:
            if (sender := sender_of(payload)) is not None:
                self._connection.publish(self._subjects.stream(sender.link, sender.stream), CUT_FRAME)
        elif headers:
            stream.handle_status(headers)
        else:
            was_unknown = not stream.other_link
            stream.handle(payload)
            if was_unknown and stream.other_link:
                self._watch(stream)

    def _watch(self, stream: NatsStream) -> None:
        """Have a stream end when the other gateway is silent, from now on."""
        if not self._pulse.presence.note_sign(stream.other_link):
            stream.lose("there are too many gateways")

    def _handle_dial(self, _subject: bytes, _headers: bytes, payload: bytes) -> None:
        self._pulse.notice_pause()
        if self._pulse.is_behind:
            # The gateway that dialled has given up.
            return
        try:
            said = parse_said(Dial, payload)
        except FrameFault as fault:
            _log.warning("a gateway that dials is not understood: %s", fault)
            return
        if self._handler is None:
            self._refuse(said, _GOING_AWAY, _LEAVING)
        elif said.version != PROTOCOL:
            self._refuse(said, _WRONG_VERSION, f"streams of version {said.version} are not spoken here, but {PROTOCOL}")
        elif len(self._streams) >= self._max_streams:
            self._refuse(said, _TRY_LATER, f"this gateway has {self._max_streams} streams already")
        else:
            stream = self._new_stream(said.gateway, said)
            self._watch(stream)
            self._tasks.start(self._serve(stream, self._handler))

    def _refuse(self, said: Dial, code: int, reason: str) -> None:
        frame = pack_frame(Kind.CLOSE, 0, pack_close(code, reason))
        self._connection.publish(self._subjects.stream(said.link, said.stream), frame)

    async def _serve(self, stream: NatsStream, handler: Handler) -> None:
        code, reason = _FAILED, "internal error"
        try:
            await handler(stream, stream.hello)
            code, reason = 1000, ""
        except StreamClosed:
            code, reason = 1000, ""
        except asyncio.CancelledError:
            code, reason = _GOING_AWAY, _LEAVING
            raise
        finally:
            await stream.close(code, reason)

    # All streams

    def mark(self, now: float) -> None:
        """Let each stream show how much it has sent."""
        for stream in tuple(self._streams.values()):
            stream.mark(now, MARK_INTERVAL)

    def drop_gone(self) -> None:
        """Lose the streams to gateways that are gone."""
        for stream in tuple(self._streams.values()):
            if stream.other_link and stream.other_link not in self._pulse.presence:
                stream.lose("the other gateway is silent or has gone")

    def lose_all(self, reason: str) -> None:
        """Lose all streams, and what came and was not received yet: it may be old."""
        for stream in tuple(self._streams.values()):
            stream.lose(reason, discard=True)

    async def close(self) -> None:
        """Close all streams politely; there are no more."""
        self._handler = None
        for stream in tuple(self._streams.values()):
            await stream.close(_GOING_AWAY, _LEAVING)
