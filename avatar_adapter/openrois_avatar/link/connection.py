"""The adapter's side of one connection of the engine link, from HELLO to BYE."""

from __future__ import annotations

import asyncio
import hmac
import logging
from collections import deque
from collections.abc import Callable
from typing import Final, Protocol, cast

from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.messages import Bye, Command, Event, Hello, LinkError, Welcome
from openrois_avatar.link.protocol import Audio, Bytes, Doorbell, Encoded, Message, Parser, Sender, Video, encode
from openrois_avatar.link.receivers import Arrivals, Receivers

FAREWELL_TIMEOUT: Final = 0.5
"""Seconds that an engine has to read BYE and to close, before its connection is aborted."""
MAX_UNREAD: Final = 256 * 1024
"""Bytes of commands that an engine may leave unread before its connection is aborted."""
MAX_QUEUED_SOUND: Final = 25
"""Blocks of the operator's sound that wait for an engine which reads slowly."""
_CONGESTED: Final = 16 * 1024
"""Unread bytes above which sound waits: 90 ms of sound."""
_LINGER: Final = 64 * 1024
_NAME: Final = "openrois-avatar"

_log = logging.getLogger(__name__)


class Host(Protocol):
    """The server of a connection."""

    def opened(self, connection: EngineConnection) -> str | None:
        """Note a new connection; a returned text refuses it."""
        ...

    def greeted(self, connection: EngineConnection) -> str | None:
        """Note an engine that has sent the secret; a returned text refuses it."""
        ...

    def ended(self, connection: EngineConnection) -> None:
        """Note that the connection has ended, or lasts only until BYE is read; called once for each opened one."""
        ...

    def gone(self, connection: EngineConnection) -> None:
        """Note that the connection is closed; called once for each opened one, after `ended`."""
        ...


class SoundQueue:
    """The operator's sound on its way to an engine, in mono and numbered; a slow engine loses the oldest blocks.

    Args:
        send: sends a block to the engine.
    """

    def __init__(self, send: Callable[[Audio], None]) -> None:
        self._send = send
        self._congested = False
        self._blocks: deque[Audio] = deque(maxlen=MAX_QUEUED_SOUND)
        self._number = 0

    def add(self, sound: RawAudio) -> None:
        """Queue a block."""
        mono = sound.samples.mean(axis=1).astype("<i2")
        self._blocks.append(Audio(self._number, round(max(0.0, sound.captured_at) * 1e9), 1, mono.tobytes()))
        self._number += 1
        self._send_waiting()

    def pause(self) -> None:
        """Hold the blocks back: the socket is congested."""
        self._congested = True

    def resume(self) -> None:
        """Send what waits: the socket has room again."""
        self._congested = False
        self._send_waiting()

    def _send_waiting(self) -> None:
        while self._blocks and not self._congested:
            self._send(self._blocks.popleft())


class EngineConnection(asyncio.BufferedProtocol):
    """The connection to an engine. Its pictures are received straight into the memory they stay in."""

    _transport: asyncio.Transport  # set by `connection_made`, before the server gets the connection

    def __init__(self, host: Host, secret: str, receivers: Receivers, greeting_timeout: float) -> None:
        self._host = host
        self._secret = secret
        self._clock = receivers.clock
        self._arrivals = Arrivals(receivers)
        self._parser = Parser(Sender.ENGINE, receivers.video.memory.allocate)
        self._hello: Hello | None = None
        self._reason: str | None = None
        self._linger: memoryview | None = None
        self._sound = SoundQueue(lambda block: self._send(encode(block)))
        self._greeting_timeout = greeting_timeout
        loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._closed: asyncio.Future[str] = loop.create_future()
        self._gone: asyncio.Future[None] = loop.create_future()

    @property
    def hello(self) -> Hello:
        """The engine's HELLO.

        Raises:
            LinkError: the engine has not been welcomed.
        """
        if self._hello is None:
            raise LinkError("the engine has not been welcomed; wait for `LinkServer.accept`")
        return self._hello

    @property
    def connected(self) -> bool:
        """Whether commands still reach the engine."""
        return self._reason is None

    async def closed(self) -> str:
        """Wait for the end of the connection and return its reason; any number of tasks may wait."""
        return await asyncio.shield(self._closed)

    async def gone(self) -> None:
        """Wait until the connection is closed, `FAREWELL_TIMEOUT` seconds after its end at the latest."""
        await asyncio.shield(self._gone)

    def send_command(self, command: Command) -> None:
        """Send a command; never waits. An engine that leaves 256 KiB of them unread is disconnected.

        Raises:
            LinkError: the engine is disconnected, or the command is longer than the link allows.
        """
        if not self.connected:
            raise LinkError(f"the engine is disconnected: {self._reason}; try again when one is connected")
        self._send(encode(command))
        if self._transport.get_write_buffer_size() > MAX_UNREAD:
            self.abort("the engine does not read its commands; read them with every picture")

    def send_audio(self, sound: RawAudio) -> None:
        """Send a block of the operator's sound, in mono, if the engine takes sound; never waits, and never raises.

        An engine that reads too slowly loses the oldest of `MAX_QUEUED_SOUND` blocks.
        """
        if self.connected and self._hello is not None and self._hello.hears:
            self._sound.add(sound)

    def close(self, reason: str) -> None:
        """Send BYE and end the connection, `FAREWELL_TIMEOUT` seconds from now at the latest."""
        if self._reason is None:
            self._reason = reason
            self._send(encode(Bye(reason)))
            # A socket that is closed while data arrives drops the data that the other side has not read.
            self._linger = memoryview(bytearray(_LINGER))
            self._transport.write_eof()
            self._allow(FAREWELL_TIMEOUT, self._transport.abort)
            asyncio.get_running_loop().call_soon(self._report_end)

    def abort(self, reason: str) -> None:
        """End the connection at once, without BYE."""
        self._reason = self._reason or reason
        self._transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Implement the asyncio protocol."""
        self._transport = cast(asyncio.Transport, transport)
        self._transport.set_write_buffer_limits(high=_CONGESTED)
        self._allow(
            self._greeting_timeout, lambda: self.close("no HELLO in time; send it as soon as the connection is open")
        )
        refusal = self._host.opened(self)
        if refusal is not None:
            self.close(refusal)

    def get_buffer(self, sizehint: int) -> memoryview:
        """Implement the asyncio protocol."""
        return self._parser.get_buffer() if self._linger is None else self._linger

    def buffer_updated(self, nbytes: int) -> None:
        """Implement the asyncio protocol."""
        if self._linger is not None:
            return  # after BYE nothing counts
        try:
            self._parser.buffer_updated(nbytes, self._handle_message)
        except LinkError as error:
            _log.warning("engine link: closed: %s", error)
            self.close(str(error))

    def pause_writing(self) -> None:
        """Implement the asyncio protocol."""
        self._sound.pause()

    def resume_writing(self) -> None:
        """Implement the asyncio protocol."""
        if self.connected:
            self._sound.resume()

    def connection_lost(self, exc: Exception | None) -> None:
        """Implement the asyncio protocol."""
        self._stop_waiting()
        if self._reason is None:
            self._reason = f"the connection broke: {exc}" if exc else "the engine closed the connection"
        self._report_end()
        self._host.gone(self)
        self._gone.set_result(None)

    def _report_end(self) -> None:
        if not self._closed.done():
            assert self._reason is not None
            self._closed.set_result(self._reason)
            self._host.ended(self)
            self._arrivals.close(self._reason)

    def _handle_message(self, message: Message) -> None:
        if self._reason is not None:
            return  # after the engine's BYE nothing counts
        match message:
            case Video() | Encoded() | Doorbell() | Audio():
                self._arrivals.handle_message(message)
            case Hello():
                self._greet(message)
            case Bye():
                self._reason = message.reason
                self._transport.close()
                self._allow(FAREWELL_TIMEOUT, self._transport.abort)
            case _:
                assert isinstance(message, Event), "the parser accepts nothing else of an engine"
                self._arrivals.handle_message(message)

    def _greet(self, hello: Hello) -> None:
        if self._secret and not hmac.compare_digest(hello.secret.encode(), self._secret.encode()):
            raise LinkError("wrong secret: HELLO must have the adapter's secret")
        refusal = self._host.greeted(self)
        if refusal is not None:
            raise LinkError(refusal)
        self._hello = hello
        self._stop_waiting()
        ring, now_ns = self._arrivals.open(hello), round(self._clock.now() * 1e9)
        self._send(encode(Welcome(_NAME, ring, now_ns)))
        _log.info("engine link: %s %s is connected", hello.name, hello.version)
        self._arrivals.announce(hello, self.send_command)

    def _send(self, parts: tuple[Bytes, ...]) -> None:
        self._transport.write(b"".join(parts))

    def _allow(self, seconds: float, then: Callable[[], None]) -> None:
        """Set the timer of the present wait, for HELLO or for the end."""
        self._stop_waiting()
        self._timer = asyncio.get_running_loop().call_later(seconds, then)

    def _stop_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
