"""Data channels under SCTP: messages bypass aiortc's channels, and hostile packets end the channels alone.

Private names in use, and why no public one does it:

* `RTCSctpTransport._handle_data` gets each decrypted packet. Its exceptions end the peer connection.
* `._receive` gets each whole message. aiortc's own opens a channel for every request, up to all stream numbers; it gets
only the other end's acknowledgement of an announced channel.
* `._inbound_streams` and `._sack_misordered` hold incomplete and unordered data; a sender that ignores the window
(`._advertised_rwnd`) makes them grow without limit.
"""

import logging
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Final

from aiortc import RTCSctpCapabilities, RTCSctpTransport
from aiortc.rtcdtlstransport import RTCDtlsTransport

from openrois_streaming.aiortc_internals import names_in
from openrois_streaming.network.guard import Allowance, GuardFigures

__all__ = ["PACKETS_LIMIT", "WINDOW", "contain_channels", "differences"]

WINDOW: Final = 64 * 1024
"""Bytes that may wait until complete and in order, and the window announced to the other end."""
PACKETS_LIMIT: Final = 512
"""Fragments of messages that may wait, and that may be ahead of a missing one."""
STREAMS_LIMIT: Final = 8
"""Streams with received data; two are used."""
AT_ONCE: Final = 256 * 1024
PER_SECOND: Final = 256 * 1024.0
"""Bytes of SCTP accepted of one peer connection. Dropped data is retransmitted."""

_ESTABLISHMENT: Final = 50
_ACK: Final = b"\x02"
"""Acknowledgement of an announced channel (RFC 8832 section 5.2)."""
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
    """Handle the data of `transport`; to be called before it starts.

    Args:
        transport: SCTP transport whose channels are all made at this end.
        max_message: limit on the bytes of a message, as announced to the other end.
        figures: count dropped data.
        on_message: gets the number of the stream and the message, as text or bytes.
    """
    contained = _Contained(transport, figures, on_message)
    transport._advertised_rwnd = WINDOW
    transport.getCapabilities = lambda: RTCSctpCapabilities(maxMessageSize=max_message)  # type: ignore[method-assign]
    transport._handle_data = contained.handle_data  # type: ignore[method-assign]
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

    async def handle_data(self, data: bytes) -> None:
        """Handle a packet in place of `_handle_data`."""
        if self._transport.state == "closed":
            return
        if not self._left.admits(len(data)):
            self._figures.overflow += 1
            return
        try:
            await self._handle(data)
        except Exception:
            self._figures.unreadable += 1
            _log.debug("a packet of SCTP cannot be parsed", exc_info=True)
        if self._is_too_much():
            _log.info("the data channels of an application are closed: its messages stay incomplete")
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
        """Handle a message in place of `_receive`."""
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
            _log.exception("a message of an application could not be handled")


def differences(transport: RTCSctpTransport) -> list[str]:
    """Return the differences from what this module relies on."""
    checks = {
        "data does not pass _handle_data": "_handle_data" in names_in(RTCDtlsTransport._recv_next),
        "messages do not pass _receive": "_receive" in names_in(RTCSctpTransport._receive_data_chunk),
        "the window is not counted": "_advertised_rwnd" in names_in(RTCSctpTransport._receive_data_chunk),
        "what is not whole waits elsewhere": transport._inbound_streams == {} and transport._sack_misordered == set(),
    }
    return [difference for difference, holds in checks.items() if not holds]
