"""Authentic RTP and RTCP on its way into aiortc: what its parsers trip over ends here, and so do sources without end.

What is reached for, and why nothing public does it:

* `RTCDtlsTransport._handle_rtp_data` and `._handle_rtcp_data` get each packet that was decrypted. What they raise ends
  the peer connection, and they raise `struct.error` on extensions and on a REMB that are shorter than they say.
* libsrtp, behind `._rx_srtp`, remembers every source (SSRC) that it has decrypted a packet of, and looks through all of
  them for each packet.
"""

import logging
from collections.abc import Callable
from typing import Final

from aiortc.rtcdtlstransport import RTCDtlsTransport

from openrois_streaming.aiortc_internals.code import names_in
from openrois_streaming.network.guard import GuardFigures

SOURCES_LIMIT: Final = 1024
"""Sources of one peer connection, of RTP and RTCP, from its beginning to its end. A browser has a handful, and another
one whenever a device is exchanged."""

_RTP_SOURCE: Final = slice(8, 12)
_RTCP_SOURCE: Final = slice(4, 8)

_log = logging.getLogger(__name__)


class Incoming:
    """Stands before `transport`; `on_rtcp` is called for each RTCP packet, whatever stream it is about.

    What cannot be taken in, or is too much, is counted in `figures`.
    """

    def __init__(self, transport: RTCDtlsTransport, on_rtcp: Callable[[], None], figures: GuardFigures) -> None:
        self._figures = figures
        self._sources: set[bytes] = set()
        self._failed = False
        self._on_rtcp = on_rtcp
        self._handle_rtp = transport._handle_rtp_data
        self._handle_rtcp = transport._handle_rtcp_data
        transport._handle_rtp_data = self._rtp_came  # type: ignore[method-assign]
        transport._handle_rtcp_data = self._rtcp_came  # type: ignore[method-assign]

    @property
    def crowded(self) -> bool:
        """Whether there were more sources than an application has; nothing is passed on then."""
        return len(self._sources) > SOURCES_LIMIT

    def _knows(self, source: bytes) -> bool:
        """Note `source`, unless there are too many; whether it may be listened to."""
        if not self.crowded:
            self._sources.add(source)
        return not self.crowded

    async def _rtp_came(self, data: bytes, arrival_time_ms: int) -> None:
        if self._knows(data[_RTP_SOURCE]):
            try:
                await self._handle_rtp(data, arrival_time_ms)
            except Exception:
                self._fail()

    async def _rtcp_came(self, data: bytes) -> None:
        if self._knows(data[_RTCP_SOURCE]):
            try:
                self._on_rtcp()
                await self._handle_rtcp(data)
            except Exception:
                self._fail()

    def _fail(self) -> None:
        """Count it, and tell it once: whoever sends such packets may send many."""
        self._figures.unreadable += 1
        if not self._failed:
            self._failed = True
            _log.info("a packet of an application cannot be taken in", exc_info=True)


def differences() -> list[str]:
    """What is not as this module expects it."""
    called = names_in(RTCDtlsTransport._recv_next)
    return [f"packets do not pass {name}" for name in ("_handle_rtp_data", "_handle_rtcp_data") if name not in called]
