"""Checks of authentic RTP and RTCP before aiortc: parser failures and floods of sources end here.

Private names in use, and why no public one does it:

* `RTCDtlsTransport._handle_rtp_data` and `._handle_rtcp_data` get each decrypted packet. Their exceptions end the peer
connection, and they raise `struct.error` on extensions and on a REMB that are shorter than they say.
* libsrtp, behind `._rx_srtp`, keeps every source (SSRC) of a decrypted packet, and searches all of them for each
packet.
"""

import logging
from collections.abc import Callable
from typing import Final

from aiortc.rtcdtlstransport import RTCDtlsTransport

from openrois_streaming.aiortc_internals import names_in
from openrois_streaming.network.guard import GuardFigures

SOURCES_LIMIT: Final = 1024
"""Limit on the sources of one peer connection, of RTP and RTCP, over its whole life. A browser has a handful, and
another one whenever a device is exchanged."""

_RTP_SOURCE: Final = slice(8, 12)
_RTCP_SOURCE: Final = slice(4, 8)

_log = logging.getLogger(__name__)


class Incoming:
    """Filter in front of `transport`; `on_rtcp` is called for each RTCP packet of any stream.

    Unreadable packets are counted in `figures`.
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
        """Whether the limit of sources is exceeded; nothing is passed on then."""
        return len(self._sources) > SOURCES_LIMIT

    def _knows(self, source: bytes) -> bool:
        """Note `source`, unless there are too many; whether its packets may pass."""
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
        """Count an unreadable packet, and log only the first: there may be many."""
        self._figures.unreadable += 1
        if not self._failed:
            self._failed = True
            _log.info("a packet of an application cannot be parsed", exc_info=True)


def differences() -> list[str]:
    """Return the differences from what this module relies on."""
    called = names_in(RTCDtlsTransport._recv_next)
    return [f"packets do not pass {name}" for name in ("_handle_rtp_data", "_handle_rtcp_data") if name not in called]
