"""The dialling side of a WebSocket as a message stream, on the `websockets` library."""

import asyncio
import logging
import ssl
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Final

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import CloseCode, Frame, Opcode
from websockets.protocol import Event, State

from openrois.aio.tasks import TaskScope
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois.transport.silence import Silence
from openrois.transport.stream import StreamClosed, close_reason

__all__ = ["WebSocketStream", "dial", "refusal"]

MAX_MESSAGE: Final = 4 << 20
"""Bytes of one incoming message; a profile of a whole fleet fits."""

OPEN_TIMEOUT: Final = 10.0
_CLOSE_TIMEOUT: Final = 1.0
_SHOWN: Final = 200

_frames = logging.getLogger(f"{__name__}.frames")
# At DEBUG the library logs every header and every frame, tokens and session descriptions too.
_frames.setLevel(logging.WARNING)
_PING_INTERVAL: Final = 4.0
_PING_TIMEOUT: Final = 5.0

_MOST_HELD: Final = 16 << 20
"""Characters that are held back until a ping is answered; more ends the connection."""


class _Connection(ClientConnection):
    """A connection that notes where something comes after a silence, pings included."""

    _silent_for: float | None = None
    _heard_at = 0.0
    _note: Callable[[], None]

    def note_silence(self, seconds: float, note: Callable[[], None]) -> None:
        """Call `note` where something comes after so many seconds without anything."""
        self._silent_for, self._heard_at, self._note = seconds, self.loop.time(), note

    def process_event(self, event: Event) -> None:
        if self._silent_for is not None:
            now = self.loop.time()
            if now >= self._heard_at + self._silent_for:
                self._note()
            self._heard_at = now
        super().process_event(event)


class WebSocketStream:
    """One open connection; a `MessageStream`.

    What comes after a long silence is in doubt: it may have waited on the way since the other side gave this one up.
    Nothing of it is received before that side has answered a ping.
    """

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self._silence = Silence()
        self._held: deque[str | bytes] = deque()
        self._is_in_doubt = False

    def doubt(self) -> None:
        """Receive nothing more before the other side has answered a ping."""
        self._is_in_doubt = True

    async def keep_alive(self) -> None:
        """Ping until the connection ends; a side that is read from and stays silent after a ping is left."""
        with suppress(ConnectionClosed):
            while True:
                await asyncio.sleep(_PING_INTERVAL)
                if await self._silence.follows(self._ping, _PING_TIMEOUT):
                    await self.close(CloseCode.INTERNAL_ERROR, "no answer to a ping")
                    return

    async def _ping(self) -> None:
        """Ping; that itself waits where the other side takes nothing in."""
        answer = asyncio.ensure_future(await self._connection.ping())
        answer.add_done_callback(lambda _answer: self._silence.received.set())

    async def receive(self) -> str:
        """Return the next text message; a binary one ends the connection with 1003."""
        self._silence.reading = True
        try:
            if not self._held:
                self._held.append(await self._connection.recv())
            if self._is_in_doubt:
                await self._prove()
            message = self._held.popleft()
        except ConnectionClosed as closed:
            raise _closed(closed) from closed
        finally:
            self._silence.reading = False
        self._silence.received.set()
        if isinstance(message, bytes):
            await self.close(1003, "text messages only")
            raise StreamClosed(1003, "text messages only")
        return message

    async def _prove(self) -> None:
        """Hold back what comes until the other side answers a ping; where it has left this raises what says so."""
        connection, size = self._connection, sum(map(len, self._held))
        self._is_in_doubt = False
        try:
            answer = asyncio.ensure_future(await connection.ping())
            # The answer may stand behind more than the library takes in before that is read.
            while not answer.done() and size <= _MOST_HELD:
                reading = asyncio.ensure_future(connection.recv())
                try:
                    await asyncio.wait({reading, answer}, return_when=asyncio.FIRST_COMPLETED)
                finally:
                    if not reading.cancel() and reading.exception() is None:
                        self._held.append(reading.result())
                        size += len(self._held[-1])
                # Only one may read at a time.
                await asyncio.wait({reading})
                if not reading.cancelled():
                    reading.result()
            if size > _MOST_HELD:
                self.abort()
            await answer
        except BaseException:
            self._is_in_doubt = True
            raise

    async def send(self, text: str) -> None:
        """Send one text message; waits while the kernel's buffer is full."""
        try:
            await self._connection.send(text)
        except ConnectionClosed as closed:
            raise _closed(closed) from closed

    def send_now(self, text: str) -> bool:
        """Send one text message if all before it have left, and tell whether that was so."""
        connection = self._connection
        if connection.state is not State.OPEN or connection.transport.get_write_buffer_size():
            return False
        connection.transport.write(Frame(Opcode.TEXT, text.encode()).serialize(mask=True))
        return True

    async def send_many(self, texts: Sequence[str]) -> None:
        """Send text messages with one write; waits while the kernel's buffer is full."""
        connection = self._connection
        transport = connection.transport
        if connection.state is not State.OPEN or len(texts) == 1 or transport.get_write_buffer_size() > 0:
            for text in texts:
                await self.send(text)
        else:
            transport.write(b"".join([Frame(Opcode.TEXT, text.encode()).serialize(mask=True) for text in texts]))

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close with the closing handshake, for at most a second, then cut."""
        try:
            # The close frame itself waits for a side that does not read.
            async with asyncio.timeout(_CLOSE_TIMEOUT):
                await self._connection.close(code, close_reason(reason))
        except TimeoutError:
            self.abort()

    def abort(self) -> None:
        """Cut the connection."""
        self._connection.transport.abort()


def refusal(error: Exception) -> str:
    """Return why there is no WebSocket: the answer that came instead, or the problem of the certificate."""
    if isinstance(error, ssl.SSLCertVerificationError):
        return f"its certificate is not trusted: {error.verify_message}"
    if not isinstance(error, InvalidStatus):
        return str(error)
    response = error.response
    text = (response.body or b"")[:_SHOWN].decode(errors="replace")
    # It goes to terminals, and its author is not known.
    said = " ".join("".join(each if each.isprintable() else " " for each in text).split())
    return f"{response.status_code}: {said or response.reason_phrase}"


def _closed(closed: ConnectionClosed) -> StreamClosed:
    frame = closed.rcvd or closed.sent
    return StreamClosed(frame.code, frame.reason) if frame is not None else StreamClosed(1006)


@asynccontextmanager
async def dial(
    url: str,
    *,
    credentials: Credentials = NO_CREDENTIALS,
    open_timeout: float | None = OPEN_TIMEOUT,
    doubt_after: float | None = None,
) -> AsyncIterator[WebSocketStream]:
    """Open a WebSocket to `url` (`ws://` or `wss://`) for as long as the block runs.

    Args:
        url: the address.
        credentials: what is shown to the other side.
        open_timeout: seconds that the handshake may take; None where the caller sees to it.
        doubt_after: seconds of silence after which what comes is received only from a side that answers a ping.

    Raises:
        ValueError: the credentials cannot be read.
        OSError: nothing listens there, or the network refuses.
        TimeoutError: no handshake in time.
        websockets.exceptions.InvalidHandshake: something answers, but not as a WebSocket server.
        websockets.exceptions.InvalidURI: `url` is no WebSocket address.
    """
    async with (
        connect(
            url,
            additional_headers=credentials.headers(),
            ssl=credentials.context(url),
            compression=None,
            max_size=MAX_MESSAGE,
            open_timeout=open_timeout,
            close_timeout=_CLOSE_TIMEOUT,
            ping_interval=None,
            proxy=None,
            logger=_frames,
            create_connection=_Connection,
        ) as connection,
        TaskScope() as tasks,
    ):
        stream = WebSocketStream(connection)
        if doubt_after is not None:
            assert isinstance(connection, _Connection)
            connection.note_silence(doubt_after, stream.doubt)
        tasks.start(stream.keep_alive())
        code = CloseCode.INTERNAL_ERROR
        try:
            yield stream
            code = CloseCode.NORMAL_CLOSURE
        except asyncio.CancelledError:
            # A task that is cancelled closes in good order; the library would report an internal error.
            code = CloseCode.GOING_AWAY
            raise
        finally:
            # The library would wait without end for a side that does not read.
            await stream.close(code)
