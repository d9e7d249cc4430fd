"""Peer connection of aiortc: the start of its sections, and the negotiated codec."""

import logging
from typing import Any

from aiortc import InvalidStateError, RTCPeerConnection, RTCRtpTransceiver

_log = logging.getLogger(__name__)


def contain_starts(connection: RTCPeerConnection) -> None:
    """Contain the start of the sections of `connection`, which a later event may overtake.

    It waits for ICE and DTLS, and meanwhile the connection may be closed, or a later answer be half applied, with a
    section more than the description in use. That answer's own start completes it.
    """
    inner: Any = connection
    start = inner._RTCPeerConnection__connect

    async def contained() -> None:
        try:
            await start()
        except (IndexError, InvalidStateError) as overtaken:
            _log.debug("the start of a section was overtaken: %r", overtaken)
        except Exception:
            _log.exception("a section could not be started")

    inner._RTCPeerConnection__connect = contained


def negotiated_codec(transceiver: RTCRtpTransceiver) -> str | None:
    """Return the media type that `transceiver` sends, once an answer was applied; None before the first offer."""
    return transceiver._codecs[0].mimeType if transceiver._codecs else None
