"""One connection of the gateway's port: aiohttp's, whose input is bounded, and checked before it is parsed."""

import asyncio
from collections.abc import Callable
from typing import Any, Final, Protocol

from aiohttp import WSCloseCode, web

from openrois.http_limits.header_timeout import Connection, HeaderTimeouts
from openrois.http_limits.websocket_frames import FrameRules

__all__ = ["HttpConnection"]

_MORE: Final = (False, b"")
"""The result of a parser that continues."""


class HttpConnection(Connection):
    """A connection.

    Attributes:
        rules: what holds for the frames of its WebSocket; to be set before the upgrade is answered.
        writable: whether little waits in front of the kernel; is set at the end, too.
    """

    __slots__ = ("_takes_frames", "rules", "writable")

    rules: FrameRules

    def __init__(self, manager: web.Server, header_timeouts: HeaderTimeouts, address: str, **options: Any) -> None:
        super().__init__(manager, header_timeouts, address, **options)
        # An upgrade that is refused leaves a connection that takes further requests.
        self._takes_frames = False
        self.writable = asyncio.Event()
        self.writable.set()

    def pause_writing(self) -> None:
        """Pause senders: the other side is slow."""
        self.writable.clear()
        super().pause_writing()

    def resume_writing(self) -> None:
        """Let senders continue."""
        self.writable.set()
        super().resume_writing()

    def connection_lost(self, exc: BaseException | None) -> None:
        """End, and release waiting senders."""
        self.writable.set()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Receive bytes; over a WebSocket no header is waited for, and nothing is looked up per message."""
        if self._takes_frames:
            web.RequestHandler.data_received(self, data)
        else:
            super().data_received(data)

    def set_parser(self, parser: Any, data_received_cb: Callable[[], None] | None = None) -> None:
        """Install the parser of frames, behind a check of them."""
        self._takes_frames = True
        checked: Any = _Checked(parser, self.rules)
        super().set_parser(checked, data_received_cb)


class _Parser(Protocol):
    def feed_data(self, data: bytes) -> tuple[bool, bytes]: ...
    def feed_eof(self) -> None: ...


class _Checked:
    """A parser that gets only what the rules let pass."""

    def __init__(self, parser: _Parser, rules: FrameRules) -> None:
        self._parser = parser
        self._rules = rules

    def feed_data(self, data: bytes) -> tuple[bool, bytes]:
        passed = self._rules.passed(data)
        if not passed:
            return _MORE
        refused, rest = self._parser.feed_data(passed)
        fault = self._rules.fault
        if not refused and fault is not None and fault.code == WSCloseCode.PROTOCOL_ERROR:
            # No closing handshake is waited for, as after what the library refuses itself; there the end would make it
            # forget why. A flood is read for as long as that takes: with unread bytes TCP would reset the connection,
            # and the close frame be lost.
            self._parser.feed_eof()
        return refused, rest

    def feed_eof(self) -> None:
        self._parser.feed_eof()
