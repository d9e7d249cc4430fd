"""A gateway's link to the other gateways of its cluster: streams to them, and which of them are there."""

import asyncio
import logging
import time
from collections import Counter
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, Final, Self

from openrois.aio.tasks import TaskScope
from openrois.cluster.connection import NatsConnection
from openrois.cluster.dial_failed import LOST, DialFailed
from openrois.cluster.exchange import Exchange, Handler
from openrois.cluster.flow import MAX_MESSAGE
from openrois.cluster.handshake import Unreachable
from openrois.cluster.presence import Present
from openrois.cluster.pulse import Pulse
from openrois.cluster.settings import NatsSettings
from openrois.cluster.stream import NatsStream
from openrois.cluster.subjects import Subjects
from openrois.transport.backoff import Backoff

__all__ = ["NatsLink", "NatsSettings", "NatsStream"]

_log = logging.getLogger(__name__)

MAX_STREAMS: Final = 4096
"""Streams of one link at a time, dialled and accepted together."""

LEAST_PAYLOAD: Final = 48 << 10
"""Bytes of a message that NATS has to take: what dials a stream fits."""


class NatsLink:
    """This gateway among those of its cluster: while it is entered, it is there for the others.

    NATS may be away: the link dials until it is back, and `trouble` says why meanwhile. Nothing is kept for later: all
    streams end when the connection to NATS does, and what is asked meanwhile fails at once.

    Args:
        settings: where NATS is.
        gateway_id: names this gateway among the others.
        attributes: what it tells all others; small.
        max_streams: at a time.
        max_message: bytes of one incoming message.
        clock: monotonic seconds.
        sleep: waits for some seconds.

    Attributes:
        gateway_id: names this gateway among the others.
        trouble: why no other gateway can be reached; empty while NATS is there.
        gaps: number of streams that ended because a frame was missing.
    """

    def __init__(
        self,
        settings: NatsSettings,
        gateway_id: str,
        *,
        attributes: Mapping[str, Any] | None = None,
        max_streams: int = MAX_STREAMS,
        max_message: int = MAX_MESSAGE,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self.gateway_id = gateway_id
        self.trouble = "NATS has not been dialled yet"
        self.gaps = 0
        self._settings = settings
        self._max_streams = max_streams
        self._max_message = max_message
        self._clock = clock
        self._sleep = sleep
        self._subjects = Subjects(settings.prefix)
        self._tasks = TaskScope()
        self._handler: Handler | None = None
        self._connection: NatsConnection | None = None
        self._exchange: Exchange | None = None
        self._pulse = Pulse(self._subjects, gateway_id, attributes or {}, clock, sleep)
        self._pulse.on_beat = lambda now: self._with_streams(lambda exchange: exchange.mark(now))
        self._pulse.on_gone = lambda: self._with_streams(Exchange.drop_gone)
        self._pulse.on_pause = lambda: self._with_streams(
            lambda exchange: exchange.lose_all("this gateway stood still")
        )

    def _with_streams(self, act: Callable[[Exchange], None]) -> None:
        if self._exchange is not None:
            act(self._exchange)

    async def __aenter__(self) -> Self:
        """Dial NATS once; where it is not there, go on dialling.

        Raises:
            ValueError: a file that the settings name cannot be used.
        """
        self._settings.login()
        if self._settings.names_tls:
            self._settings.context()
        await self._tasks.__aenter__()
        tried = asyncio.Event()
        self._tasks.start(self._keep_connected(tried))
        self._tasks.start(self._pulse.run())
        await tried.wait()
        return self

    async def __aexit__(self, *_error: object) -> None:
        connection, exchange, self._exchange = self._connection, self._exchange, None
        self.trouble = "the link was left"
        if exchange is not None:
            await exchange.close()
        await self._tasks.__aexit__(None, None, None)
        self._pulse.leave()
        if connection is not None:
            await connection.flush()
            connection.abort("the link was left")

    def __len__(self) -> int:
        """Return how many streams there are."""
        return 0 if self._exchange is None else len(self._exchange)

    def count_streams(self) -> Counter[str]:
        """Return how many streams there are with each gateway."""
        return Counter() if self._exchange is None else self._exchange.count_streams()

    @property
    def present(self) -> Mapping[str, Present]:
        """The gateways that are there now, this one too, by id; none while NATS is away."""
        return self._pulse.presence.present

    def on_presence(self, listener: Callable[[Mapping[str, Present]], None]) -> Callable[[], None]:
        """Call `listener` when a gateway comes, changes or goes; return a function that removes it."""
        return self._pulse.listeners.add(listener)

    def notice_pause(self) -> None:
        """Lose all streams where this process stood still for so long that the others have given it up.

        What begins something that was asked of it before calls this first.
        """
        self._pulse.notice_pause()

    def announce(self, attributes: Mapping[str, Any]) -> None:
        """Tell all other gateways these attributes from now on.

        Raises:
            ValueError: they are too much.
        """
        self._pulse.announce(attributes)

    async def listen(self, handler: Handler) -> None:
        """Let other gateways dial this one from now on, until the link is left.

        Args:
            handler: called in a task of its own with each stream and with what the other gateway asserts. A stream that
                it closes before it has received or sent is refused, with the code and the reason of `close`; one that
                is open when it returns is closed.

        Raises:
            RuntimeError: there is a handler already.
        """
        if self._handler is not None:
            raise RuntimeError("this link has a handler already: one handles all streams")
        self._handler = handler
        if self._exchange is not None and self._connection is not None:
            self._exchange.listen(handler)
            await self._connection.flush()

    async def dial(self, gateway_id: str, hello: Mapping[str, Any]) -> NatsStream:
        """Return a stream to another gateway, which ends by itself when this link is left.

        Args:
            gateway_id: of the other gateway.
            hello: what is asserted to it: a small object for JSON.

        Raises:
            DialFailed: it is not reached or refuses, within a second.
            ValueError: the id cannot be one, or what is asserted is too long.
        """
        if self._exchange is None:
            raise DialFailed(gateway_id, LOST, self.trouble)
        return await self._exchange.dial(gateway_id, hello)

    async def _keep_connected(self, tried: asyncio.Event) -> None:
        """Have a connection to NATS whenever there can be one, for ever."""
        backoff = Backoff(first=0.1, factor=2, limit=1.0, lasting=5.0)
        while True:
            began = self._clock()
            try:
                connection = await self._open()
            finally:
                tried.set()
            if connection is not None:
                await connection.lost.wait()
            await self._sleep(backoff.after(self._clock() - began))

    async def _open(self) -> NatsConnection | None:
        """Dial each server until one admits this gateway."""
        for server in self._settings.servers:
            try:
                name = f"openrois gateway {self.gateway_id}"
                connection = await NatsConnection.open(self._settings, server, name, self._handle_loss)
            except Unreachable as problem:
                self._note_trouble(str(problem))
                continue
            if not connection.is_open:
                self._note_trouble(connection.reason)
                continue
            if connection.max_payload < LEAST_PAYLOAD:
                connection.abort("not used")
                remedy = f"set its max_payload to {LEAST_PAYLOAD} or more"
                self._note_trouble(f"NATS at {server} takes {connection.max_payload} bytes at a time: {remedy}")
                continue
            self._begin(connection)
            # From then on what is dialled is there.
            await connection.flush()
            return connection
        return None

    def _begin(self, connection: NatsConnection) -> None:
        self._connection = connection
        self._exchange = Exchange(
            connection,
            self._subjects,
            self.gateway_id,
            self._pulse,
            self._tasks,
            max_streams=self._max_streams,
            max_message=self._max_message,
            on_gap=self._note_gap,
        )
        if self._handler is not None:
            self._exchange.listen(self._handler)
        self._pulse.begin(connection, self._exchange.link)
        self.trouble = ""
        _log.info("gateway %r is in its cluster, by NATS at %s", self.gateway_id, connection.server)

    def _handle_loss(self, reason: str) -> None:
        exchange, self._connection, self._exchange = self._exchange, None, None
        if exchange is not None:
            self._note_trouble(reason)
            exchange.lose_all(reason)
            self._pulse.lose_connection()

    def _note_gap(self) -> None:
        self.gaps += 1

    def _note_trouble(self, problem: str) -> None:
        if problem != self.trouble:
            _log.warning("%s", problem)
        self.trouble = problem
