"""One stream between two gateways over NATS; a `MessageStream` and a `BatchStream`."""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any, Final

from openrois.aio.tasks import Deadline
from openrois.cluster.connection import NatsConnection
from openrois.cluster.dial_failed import LOST
from openrois.cluster.flow import MESSAGE_COST, PIECE, Receiving, Sending
from openrois.cluster.frames import (
    CUT_FRAME,
    FRAME_HEAD,
    Accept,
    Address,
    Dial,
    Frame,
    FrameFault,
    FrameGap,
    Kind,
    pack_close,
    pack_grant,
    parse_close,
    parse_frame,
    parse_grant,
    parse_said,
)
from openrois.cluster.subjects import Subjects
from openrois.transport.stream import StreamClosed

__all__ = ["NatsStream", "sender_of"]

_CLOSE_TIMEOUT: Final = 1.0
_WRONG_TEXT: Final = 1007
_TOO_LONG: Final = 1009
_NO_RESPONDERS: Final = b"NATS/1.0 503"


class NatsStream:
    """One end of a stream.

    Whichever way it is lost, by a frame that is missing, by a gateway that is silent or by NATS, it ends with 1006, and
    nothing that was sent is sent again.

    Args:
        connection: this gateway's.
        subjects: where frames go.
        address: of this end.
        receiving: the direction that comes here.
        on_end: called with this end when it has ended.
        gateway_id: of the other gateway.
        dialled_by: what it said, if it has dialled.

    Attributes:
        address: of this end.
        gateway_id: of the other gateway.
        hello: what it asserted, if it has dialled.
        opened: is set when it has accepted or refused a stream that was dialled here.
        closed: the reason for which the stream has ended; None while it lives.
        has_gap: whether it has ended because a frame was missing.
    """

    def __init__(
        self,
        connection: NatsConnection,
        subjects: Subjects,
        address: Accept,
        receiving: Receiving,
        on_end: Callable[["NatsStream"], None],
        *,
        gateway_id: str,
        dialled_by: Dial | None = None,
    ) -> None:
        self._connection = connection
        self._subjects = subjects
        self._receiving = receiving
        self._on_end = on_end
        self._other: Accept | None = None
        self._subject = ""
        self._sending = Sending(address.window, PIECE)
        self._is_accepted = dialled_by is None
        self._is_sending = False
        self._credited = asyncio.Event()
        self._arrived: asyncio.Future[None] | None = None
        self._is_marked = False
        self._marked_at = 0.0
        self.address = address
        self.gateway_id = gateway_id
        self.hello: Mapping[str, Any] = {}
        self.opened = asyncio.Event()
        self.closed: StreamClosed | None = None
        self.has_gap = False
        if dialled_by is not None:
            self.hello = dialled_by.hello
            self._meet(dialled_by)

    @property
    def number(self) -> int:
        """The number of this end among those of its gateway."""
        return self.address.stream

    @property
    def other_link(self) -> str:
        """The token of the other gateway's connection; empty until that is known."""
        return "" if self._other is None else self._other.link

    @property
    def held(self) -> int:
        """Bytes of messages that came and were not received yet."""
        return self._receiving.held

    def _meet(self, other: Accept) -> None:
        self._other = other
        self._subject = self._subjects.stream(other.link, other.stream)
        self._sending = Sending(other.window, min(PIECE, self._connection.max_payload - FRAME_HEAD))

    # What comes

    def handle(self, data: bytes) -> None:
        """Take in what came to this end."""
        try:
            frame = parse_frame(data)
            if self.closed is not None:
                return
            if frame.kind is Kind.CUT:
                self._end_stream(StreamClosed(LOST, "the other gateway has lost the stream"))
                return
            self._receiving.count(frame.number)
            self._handle_frame(frame)
        except FrameFault as fault:
            self.has_gap = isinstance(fault, FrameGap)
            self.lose(str(fault))
        except OverflowError as fault:
            self._refuse(_TOO_LONG, str(fault))

    def _handle_frame(self, frame: Frame) -> None:
        match frame.kind:
            case Kind.ACCEPT:
                self._handle_accept(parse_said(Accept, frame.body))
            case Kind.CREDIT:
                self._sending.grant(parse_grant(frame.body))
                self._credited.set()
            case Kind.ALIVE:
                # That it has the number that was due is all there is to it.
                pass
            case Kind.CLOSE:
                self._end_stream(StreamClosed(*parse_close(frame.body)))
            case _:
                self._receiving.put(frame)
                if self._arrived is not None and len(self._receiving) and not self._arrived.done():
                    self._arrived.set_result(None)
                if not len(self._receiving):
                    self._grant()

    def _handle_accept(self, other: Accept) -> None:
        if self._other is not None:
            raise FrameFault("a stream is accepted once")
        self._meet(other)
        self.opened.set()

    def handle_status(self, headers: bytes) -> None:
        """Note what NATS itself says of what was published: that no gateway listens there."""
        if self._other is None and headers.startswith(_NO_RESPONDERS):
            self._end_stream(StreamClosed(LOST, "no gateway of that id listens"))

    # MessageStream

    async def receive(self) -> str:
        """Return the next message; what came before a close is still received."""
        self.accept()
        while not len(self._receiving):
            if self.closed is not None:
                raise self._closed(self.closed)
            self._arrived = asyncio.get_running_loop().create_future()
            try:
                await self._arrived
            finally:
                self._arrived = None
        data = self._receiving.pop()
        self._grant()
        try:
            return data.decode()
        except UnicodeDecodeError:
            self._refuse(_WRONG_TEXT, "text messages only")
            raise StreamClosed(_WRONG_TEXT, "text messages only") from None

    async def send(self, text: str) -> None:
        """Send one message; waits while the other side has granted nothing, or NATS is slow."""
        await self._send_all(self._sending_of().pieces(text.encode()))

    def send_now(self, text: str) -> bool:
        """Send one message if it may leave at once, and tell whether that was so."""
        data = text.encode()
        sending, cost = self._sending_of(), len(data) + MESSAGE_COST
        is_free = self.closed is None and not self._is_sending and self._connection.is_writable
        if not is_free or len(data) > sending.piece or not sending.allows(cost):
            return False
        self._publish(Kind.TEXT, data, cost)
        return True

    async def send_many(self, texts: Sequence[str]) -> None:
        """Send messages, many in one frame; waits while the other side has granted nothing, or NATS is slow."""
        await self._send_all(self._sending_of().batches([text.encode() for text in texts]))

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Say so, behind all that was sent, and end; waits for NATS to take that in, for at most a second."""
        if self.closed is None:
            body = pack_close(code, reason)
            if self._subject:
                self._connection.publish(self._subject, self._sending.frame(Kind.CLOSE, body))
            self._end_stream(StreamClosed(*parse_close(body)))
        with suppress(TimeoutError), Deadline(_CLOSE_TIMEOUT):
            await self._connection.writable()

    def abort(self) -> None:
        """End at once; the other side learns it where NATS is there."""
        self.lose("")

    # Sending

    def _sending_of(self) -> Sending:
        self.accept()
        return self._sending

    async def _send_all(self, frames: Iterator[tuple[Kind, bytes, int]]) -> None:
        self._is_sending = True
        is_within = False
        try:
            for kind, body, cost in frames:
                await self._wait_for_credit(cost)
                self._publish(kind, body, cost)
                is_within = kind is Kind.PART
        finally:
            self._is_sending = False
            if is_within:
                # Nothing else may follow a piece than the next one.
                self.lose("a message was given up half-way")

    async def _wait_for_credit(self, cost: int) -> None:
        while True:
            if self.closed is not None:
                raise self._closed(self.closed)
            if not self._connection.is_open:
                self.lose(self._connection.reason)
            elif not self._sending.allows(cost):
                self._credited.clear()
                await self._credited.wait()
            elif not self._connection.is_writable:
                await self._connection.writable()
            else:
                return

    def _publish(self, kind: Kind, body: bytes, cost: int = 0) -> None:
        self._connection.publish(self._subject, self._sending.frame(kind, body, cost))
        self._is_marked = False

    def accept(self) -> None:
        """Accept a stream that another gateway dialled, as receiving and sending do; before, `close` refuses it."""
        if not self._is_accepted and self.closed is None:
            self._is_accepted = True
            self._publish(Kind.ACCEPT, self.address.model_dump_json().encode())

    def _grant(self) -> None:
        if self.closed is None and (granted := self._receiving.next_grant()) is not None:
            self._publish(Kind.CREDIT, pack_grant(granted))

    def mark(self, now: float, interval: float) -> None:
        """Show how many frames were sent, if there were some since the last time or that was `interval` seconds ago.

        A frame that was lost is noticed by the next one: behind the last one, this is it.
        """
        if self._subject and (not self._is_marked or now >= self._marked_at + interval):
            address = Address(link=self.address.link, stream=self.address.stream)
            self._publish(Kind.ALIVE, address.model_dump_json().encode())
            self._is_marked, self._marked_at = True, now

    # The end

    def _refuse(self, code: int, reason: str) -> None:
        """End for what came, and say why."""
        if self.closed is None:
            self._connection.publish(self._subject, self._sending.frame(Kind.CLOSE, pack_close(code, reason)))
            self._end_stream(StreamClosed(code, reason))

    def lose(self, reason: str, *, discard: bool = False) -> None:
        """End as a lost connection does.

        Args:
            reason: in words.
            discard: whether what came and was not received yet is dropped: it may be old.
        """
        if discard:
            self._receiving.discard()
        if self.closed is None:
            if self._subject:
                self._connection.publish(self._subject, CUT_FRAME)
            self._end_stream(StreamClosed(LOST, reason))

    def _end_stream(self, closed: StreamClosed) -> None:
        self.closed = closed
        self._credited.set()
        if self._arrived is not None and not self._arrived.done():
            self._arrived.set_result(None)
        self.opened.set()
        self._on_end(self)

    @staticmethod
    def _closed(closed: StreamClosed) -> StreamClosed:
        """Return an exception of its own for each that is raised: they keep their tracebacks."""
        return StreamClosed(closed.code, closed.reason)


def sender_of(data: bytes) -> Address | None:
    """Return where a frame is from that came for a stream that is not there, if the frame says so."""
    with suppress(FrameFault):
        frame = parse_frame(data)
        if frame.kind in (Kind.ACCEPT, Kind.ALIVE):
            return parse_said(Address, frame.body)
    return None
