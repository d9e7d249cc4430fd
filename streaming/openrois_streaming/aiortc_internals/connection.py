"""The peer connection itself: the start of its sections, and the codec that was negotiated."""

import logging
from typing import Any

from aiortc import InvalidStateError, RTCPeerConnection, RTCRtpTransceiver

_log = logging.getLogger(__name__)


def contain_starts(connection: RTCPeerConnection) -> None:
    """Let what starts the sections of `connection` end quietly where it is overtaken.

    It waits for ICE and DTLS, and meanwhile the connection may be closed, or a later answer be half applied, which has
    a section more than the description that is looked at. That answer's own start does what this one leaves.
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
    """The media type that `transceiver` sends; meaningful once an answer was applied, None before the first offer."""
    return transceiver._codecs[0].mimeType if transceiver._codecs else None
