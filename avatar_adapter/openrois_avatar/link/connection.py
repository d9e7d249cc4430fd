"""One connection of the engine link as the adapter sees it, from the greeting to the farewell."""

from __future__ import annotations

import asyncio
import hmac
import logging
from collections.abc import Callable
from typing import Final, Protocol, cast

from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.messages import Bye, Command, Event, Hello, LinkError, Welcome
from openrois_avatar.link.protocol import Audio, Bytes, Doorbell, Encoded, Message, Parser, Sender, Video, encode
from openrois_avatar.link.receivers import Arrivals, Receivers
from openrois_avatar.link.unheard import Unheard

FAREWELL_TIMEOUT: Final = 0.5
"""Seconds that a peer has to take our goodbye and to close, before its connection is aborted."""
MAX_UNREAD: Final = 256 * 1024
"""Bytes of commands that an engine may leave unread before it is cut off."""
_CONGESTED: Final = 16 * 1024
"""Bytes that the engine has not read yet above which sound waits: 90 ms of it."""
_LINGER: Final = 64 * 1024
_NAME: Final = "openrois-avatar"

_log = logging.getLogger(__name__)


class Host(Protocol):
    """What a connection asks of the server it belongs to."""

    def opened(self, connection: EngineConnection) -> str | None:
        """A connection was made; a text says why it cannot stay."""
        ...

    def greeted(self, connection: EngineConnection) -> str | None:
        """An engine that knows the secret is there; a text says why it cannot stay."""
        ...

    def ended(self, connection: EngineConnection) -> None:
        """The connection has ended, or lasts until our goodbye has been read; called once for each that was opened."""
        ...

    def gone(self, connection: EngineConnection) -> None:
        """The connection is gone; called once for each that was opened, after `ended`."""
        ...


class EngineConnection(asyncio.BufferedProtocol):
    """A connected engine. Its pictures are received straight into the memory they stay in."""

    _transport: asyncio.Transport  # there from `connection_made` on, before anybody else sees the connection

    def __init__(self, host: Host, secret: str, receivers: Receivers, greeting_timeout: float) -> None:
        self._host = host
        self._secret = secret
        self._clock = receivers.clock
        self._arrivals = Arrivals(receivers)
        self._parser = Parser(Sender.ENGINE, receivers.video.memory.take)
        self._hello: Hello | None = None
        self._reason: str | None = None
        self._linger: memoryview | None = None
        self._unheard = Unheard(lambda block: self._send(encode(block)))
        self._greeting_timeout = greeting_timeout
        loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._closed: asyncio.Future[str] = loop.create_future()
        self._gone: asyncio.Future[None] = loop.create_future()

    @property
    def hello(self) -> Hello:
        """What the engine said of itself.

        Raises:
            LinkError: it has not been welcomed.
        """
        if self._hello is None:
            raise LinkError("the engine has not been welcomed")
        return self._hello

    @property
    def connected(self) -> bool:
        """Whether commands still reach the engine."""
        return self._reason is None

    async def closed(self) -> str:
        """Wait for the end of the connection and give its reason; any number of tasks may wait."""
        return await asyncio.shield(self._closed)

    async def gone(self) -> None:
        """Wait until nothing is left of the connection, `FAREWELL_TIMEOUT` seconds after its end at the latest."""
        await asyncio.shield(self._gone)

    def send_command(self, command: Command) -> None:
        """Send a command; never waits. An engine that leaves 256 KiB of them unread is cut off.

        Raises:
            LinkError: the engine is gone, or the command is longer than the link allows.
        """
        if not self.connected:
            raise LinkError(f"the engine is gone: {self._reason}")
        self._send(encode(command))
        if self._transport.get_write_buffer_size() > MAX_UNREAD:
            self.abort("the engine does not read its commands")

    def send_audio(self, sound: RawAudio) -> None:
        """Let the engine hear a block of sound, in mono, if it wants to; never waits, and never raises.

        An engine that reads too slowly misses the oldest of `MAX_UNHEARD` blocks.
        """
        if self.connected and self._hello is not None and self._hello.hears:
            self._unheard.add(sound)

    def close(self, reason: str) -> None:
        """Say goodbye and end the connection, `FAREWELL_TIMEOUT` seconds from now at the latest."""
        if self._reason is None:
            self._reason = reason
            self._send(encode(Bye(reason)))
            # A socket that is closed while something comes in takes back what the other side has not read of it.
            self._linger = memoryview(bytearray(_LINGER))
            self._transport.write_eof()
            self._allow(FAREWELL_TIMEOUT, self._transport.abort)
            asyncio.get_running_loop().call_soon(self._end)

    def abort(self, reason: str) -> None:
        """End the connection at once, without a goodbye."""
        self._reason = self._reason or reason
        self._transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Called by the event loop."""
        self._transport = cast(asyncio.Transport, transport)
        self._transport.set_write_buffer_limits(high=_CONGESTED)
        self._allow(self._greeting_timeout, lambda: self.close("no HELLO in time"))
        refusal = self._host.opened(self)
        if refusal is not None:
            self.close(refusal)

    def get_buffer(self, sizehint: int) -> memoryview:
        """Called by the event loop."""
        return self._parser.get_buffer() if self._linger is None else self._linger

    def buffer_updated(self, nbytes: int) -> None:
        """Called by the event loop."""
        if self._linger is not None:
            return  # after our goodbye nothing counts
        try:
            self._parser.buffer_updated(nbytes, self._take)
        except LinkError as error:
            _log.warning("engine link: closed: %s", error)
            self.close(str(error))

    def pause_writing(self) -> None:
        """Called by the event loop."""
        self._unheard.pause()

    def resume_writing(self) -> None:
        """Called by the event loop."""
        if self.connected:
            self._unheard.go_on()

    def connection_lost(self, exc: Exception | None) -> None:
        """Called by the event loop."""
        self._stop_waiting()
        if self._reason is None:
            self._reason = f"the connection broke: {exc}" if exc else "the engine closed the connection"
        self._end()
        self._host.gone(self)
        self._gone.set_result(None)

    def _end(self) -> None:
        if not self._closed.done():
            assert self._reason is not None
            self._closed.set_result(self._reason)
            self._host.ended(self)
            self._arrivals.end(self._reason)

    def _take(self, message: Message) -> None:
        if self._reason is not None:
            return  # after its goodbye nothing counts
        match message:
            case Video() | Encoded() | Doorbell() | Audio():
                self._arrivals.take(message)
            case Hello():
                self._greet(message)
            case Bye():
                self._reason = message.reason
                self._transport.close()
                self._allow(FAREWELL_TIMEOUT, self._transport.abort)
            case _:
                assert isinstance(message, Event), "the parser lets an engine say nothing else"
                self._arrivals.take(message)

    def _greet(self, hello: Hello) -> None:
        if self._secret and not hmac.compare_digest(hello.secret.encode(), self._secret.encode()):
            raise LinkError("wrong secret")
        refusal = self._host.greeted(self)
        if refusal is not None:
            raise LinkError(refusal)
        self._hello = hello
        self._stop_waiting()
        ring, now_ns = self._arrivals.begin(hello), round(self._clock.now() * 1e9)
        self._send(encode(Welcome(_NAME, ring, now_ns)))
        _log.info("engine link: %s %s is connected", hello.name, hello.version)
        self._arrivals.announce(hello, self.send_command)

    def _send(self, parts: tuple[Bytes, ...]) -> None:
        self._transport.write(b"".join(parts))

    def _allow(self, seconds: float, then: Callable[[], None]) -> None:
        """Allow `seconds` for the one thing that is waited for now, the greeting or the end."""
        self._stop_waiting()
        self._timer = asyncio.get_running_loop().call_later(seconds, then)

    def _stop_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
