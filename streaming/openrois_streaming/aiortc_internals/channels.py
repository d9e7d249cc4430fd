"""Data channels under SCTP: what arrives is taken past aiortc's channels, and hostile packets end the channels alone.

What is reached for, and why nothing public does it:

* `RTCSctpTransport._handle_data` gets each packet that was decrypted. What it raises ends the peer connection.
* `._receive` gets each whole message. aiortc's own opens a channel for whoever asks, as many as there are numbers; it
  gets nothing but the other end's agreement to a channel that was announced to it.
* `._inbound_streams` and `._sack_misordered` hold what is not whole or not in order; a sender that ignores the window
  (`._advertised_rwnd`) makes them grow without end.
"""

import logging
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from aiortc import RTCSctpCapabilities, RTCSctpTransport
from aiortc.rtcdtlstransport import RTCDtlsTransport

from openrois_streaming.aiortc_internals.code import names_in
from openrois_streaming.network.guard import Allowance, GuardFigures

__all__ = ["PACKETS_LIMIT", "WINDOW", "contain_channels", "differences"]

WINDOW: Final = 64 * 1024
"""Bytes that may wait until they are whole and in order; and that the other end is told there is room for."""
PACKETS_LIMIT: Final = 512
"""Pieces of messages that may wait so, and numbers of them that may be ahead of what is missing."""
STREAMS_LIMIT: Final = 8
"""Streams that anything may have arrived in; two are used."""
AT_ONCE: Final = 256 * 1024
PER_SECOND: Final = 256 * 1024.0
"""Bytes of SCTP that are taken of one peer connection. What is dropped comes again."""

_ESTABLISHMENT: Final = 50
_ACK: Final = b"\x02"
"""How a channel that was announced is agreed to (RFC 8832 section 5.2)."""
_TEXT: Final = 51
_TEXTS: Final = frozenset({_TEXT, 56})
"""Payload protocol identifiers of texts (RFC 8831 section 8): one, and an empty one."""

_log = logging.getLogger(__name__)


def contain_channels(
    transport: RTCSctpTransport,
    max_message: int,
    figures: GuardFigures,
    on_message: Callable[[int, str | bytes], None],
) -> None:
    """Take what arrives in `transport`; to be called before it starts.

    Args:
        transport: whose channels are all made at this end.
        max_message: bytes of a message that the other end is told it may send.
        figures: where is counted what is not taken.
        on_message: gets the number of the stream and the message: a text, or bytes that are none.
    """
    contained = _Contained(transport, figures, on_message)
    transport._advertised_rwnd = WINDOW
    transport.getCapabilities = lambda: RTCSctpCapabilities(maxMessageSize=max_message)  # type: ignore[method-assign]
    transport._handle_data = contained.take  # type: ignore[method-assign]
    transport._receive = contained.receive  # type: ignore[method-assign,assignment]


class _Contained:
    def __init__(
        self, transport: RTCSctpTransport, figures: GuardFigures, on_message: Callable[[int, str | bytes], None]
    ) -> None:
        self._transport = transport
        self._figures = figures
        self._on_message = on_message
        self._handle = transport._handle_data
        self._agree = transport._receive
        self._left = Allowance(time.monotonic, AT_ONCE, PER_SECOND)

    async def take(self, data: bytes) -> None:
        """In the place of `_handle_data`."""
        if self._transport.state == "closed":
            return
        if not self._left.admits(len(data)):
            self._figures.overflow += 1
            return
        try:
            await self._handle(data)
        except Exception:
            self._figures.unreadable += 1
            _log.debug("a packet of SCTP cannot be taken in", exc_info=True)
        if self._is_too_much():
            _log.info("the data channels of an application end: what it sends is never whole")
            self._figures.overflow += 1
            await self._transport.stop()

    def _is_too_much(self) -> bool:
        streams = self._transport._inbound_streams
        waiting = sum(len(stream.reassembly) for stream in streams.values())
        return (
            len(streams) > STREAMS_LIMIT
            or self._transport._advertised_rwnd < 0
            or max(waiting, len(self._transport._sack_misordered)) > PACKETS_LIMIT
        )

    async def receive(self, stream_id: int, protocol: int, data: bytes) -> None:
        """In the place of `_receive`."""
        message: str | bytes = data
        if protocol == _ESTABLISHMENT:
            if data == _ACK and stream_id in self._transport._data_channels:
                await self._agree(stream_id, protocol, data)
            return
        if protocol in _TEXTS:
            with suppress(UnicodeDecodeError):
                message = data.decode() if protocol == _TEXT else ""
        try:
            self._on_message(stream_id, message)
        except Exception:
            _log.exception("a message of an application could not be taken")


def differences(transport: RTCSctpTransport) -> list[str]:
    """What is not as this module expects it."""
    checks = {
        "data does not pass _handle_data": "_handle_data" in names_in(RTCDtlsTransport._recv_next),
        "messages do not pass _receive": "_receive" in names_in(RTCSctpTransport._receive_data_chunk),
        "the window is not counted": "_advertised_rwnd" in names_in(RTCSctpTransport._receive_data_chunk),
        "what is not whole waits elsewhere": transport._inbound_streams == {} and transport._sack_misordered == set(),
    }
    return [difference for difference, holds in checks.items() if not holds]
