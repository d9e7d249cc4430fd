"""The only place that touches names of aiortc and aioice that are not public. `self_test` says whether they still hold.

What is reached for, and why nothing public does it:

* `RTCRtpSender._send_keyframe` is called for PLI and FIR; for pre-encoded media aiortc forgets the request.
* `RTCRtpSender._handle_rtcp_packet` and `RTCDtlsTransport._handle_rtcp_data` get the receiver's reports; `getStats`
  does not say when they came.
* `RTCRtpSender._send_rtcp` sends the reports by which a viewer brings sound and pictures together. aiortc dates them by
  when a frame was sent; what has to be in time is when it was captured.
* `RTCRtpTransceiver._codecs` is what was negotiated.
* `RTCIceTransport._connection` is the aioice connection: its gathering waits 5 s for a server that does not answer, and
  its consent checks take 30 s to notice that the other end is gone.
"""

import functools
import logging
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, Final

from aioice import stun
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCRtpTransceiver
from aiortc.rtcconfiguration import RTCBundlePolicy
from aiortc.rtcdtlstransport import RTCDtlsTransport, RtpRouter
from aiortc.rtcicetransport import RTCIceTransport
from aiortc.rtp import RTCP_PSFB_PLI, RtcpPsfbPacket, RtcpReceiverInfo, RtcpRrPacket, RtcpSrPacket

TESTED: Final = {"aiortc": "1.16.", "aioice": "0.13."}
"""The versions that the tests of this package ran with."""

GATHER_TIMEOUT = 2
"""Seconds that STUN and TURN servers have to answer while candidates are gathered; host candidates need none."""

_NTP_EPOCH: Final = 2_208_988_800  # seconds from 1900 to 1970
_LAST_REPORT: Final = "_RTCRtpSender__lsr"

_log = logging.getLogger(__name__)


class UnsupportedLibrary(RuntimeError):
    """An installed aiortc or aioice is not one that this package was made for. The text says what differs."""


@dataclass(frozen=True, slots=True)
class ReceiverReport:
    """What a receiver says about one of our senders (RFC 3550 section 6.4.1).

    `highest_sequence` is extended to 32 bits, `fraction_lost` is 0..1 since the report before, `packets_lost` counts
    from the start, `jitter` is in units of the RTP clock.
    """

    highest_sequence: int
    fraction_lost: float
    packets_lost: int
    jitter: int


def watch_sender(
    sender: RTCRtpSender, *, on_report: Callable[[ReceiverReport], None], on_key_frame: Callable[[], None]
) -> None:
    """Call `on_report` for each receiver report about `sender`, and `on_key_frame` for each PLI or FIR."""
    handle = sender._handle_rtcp_packet
    report = _contained(on_report)

    async def handle_and_tell(packet: Any) -> None:
        await handle(packet)
        if isinstance(packet, RtcpRrPacket | RtcpSrPacket):
            for each in packet.reports:
                if each.ssrc == sender._ssrc:
                    report(
                        ReceiverReport(each.highest_sequence, each.fraction_lost / 256, each.packets_lost, each.jitter)
                    )

    sender._handle_rtcp_packet = handle_and_tell  # type: ignore[method-assign]
    sender._send_keyframe = _contained(on_key_frame)  # type: ignore[method-assign]


def watch_rtcp(transport: RTCDtlsTransport, on_rtcp: Callable[[], None]) -> None:
    """Call `on_rtcp` for each authentic RTCP packet that arrives, whatever stream it is about."""
    handle = transport._handle_rtcp_data
    tell = _contained(on_rtcp)

    async def tell_and_handle(data: bytes) -> None:
        tell()
        await handle(data)

    transport._handle_rtcp_data = tell_and_handle  # type: ignore[method-assign]


def date_by_capture(sender: RTCRtpSender, captured_at: Callable[[], float | None]) -> None:
    """Have the reports of `sender` say when the frame that it sent last was captured (RFC 3550 section 6.4.1).

    `captured_at` gives that time in seconds since the epoch, by a clock that all senders of a viewer share; None before
    the first frame.
    """
    send = sender._send_rtcp

    async def date_and_send(packets: list[Any]) -> None:
        moment = captured_at()
        for packet in packets:
            if moment is not None and isinstance(packet, RtcpSrPacket):
                dated = round((moment + _NTP_EPOCH) * 2**32) & (2**64 - 1)
                packet.sender_info.ntp_timestamp = dated
                # By its middle bits aiortc recognises the report in an answer, and so finds the round-trip time.
                setattr(sender, _LAST_REPORT, dated >> 16 & 0xFFFFFFFF)
        await send(packets)

    sender._send_rtcp = date_and_send  # type: ignore[method-assign]


def negotiated_codec(transceiver: RTCRtpTransceiver) -> str | None:
    """The media type that `transceiver` sends; meaningful once an answer was applied, None before the first offer."""
    return transceiver._codecs[0].mimeType if transceiver._codecs else None


def limit_gathering(transport: RTCIceTransport) -> None:
    """Wait `GATHER_TIMEOUT` at most for STUN and TURN servers. To be called before the first description is made."""
    connection = transport._connection
    connection.get_component_candidates = functools.partial(  # type: ignore[method-assign]
        connection.get_component_candidates, timeout=GATHER_TIMEOUT
    )


async def ask_for_a_sign(transport: RTCIceTransport) -> bool:
    """Send one ICE connectivity check over the selected pair; whether an authentic answer came within 0.5 s.

    Every ICE agent must answer it (RFC 8445 section 7.3), also when it has no media to send.
    """
    connection = transport._connection
    pair = connection._nominated.get(1)
    if pair is None or connection.remote_password is None:
        return False
    try:
        await pair.protocol.request(
            connection.build_request(pair, nominate=False),
            pair.remote_addr,
            integrity_key=connection.remote_password.encode(),
            retransmissions=0,
        )
    except (stun.TransactionError, OSError):
        return False
    return True


def _contained(call: Callable[..., None]) -> Callable[..., None]:
    """`call`, whose failure ends in the log: in aiortc's receiving loop it would end the peer connection."""

    @functools.wraps(call)
    def contained(*args: object) -> None:
        try:
            call(*args)
        except Exception:
            _log.exception("a callback failed")

    return contained


async def self_test() -> None:
    """Try on a peer connection of its own all that this module relies on; opens no socket.

    Raises:
        UnsupportedLibrary: something is not as it was in the tested versions.
    """
    for name, tested in TESTED.items():
        if not version(name).startswith(tested):
            raise UnsupportedLibrary(f"{name} {version(name)} is installed; tested are {tested}*")
    connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
    try:
        wrong = await _differences(connection)
    except (AttributeError, TypeError) as error:
        wrong = [str(error)]
    finally:
        await connection.close()
    if wrong:
        raise UnsupportedLibrary("; ".join(wrong))


async def _differences(connection: RTCPeerConnection) -> list[str]:
    transceiver = connection.addTransceiver("video", direction="sendonly")
    sender, dtls = transceiver.sender, transceiver.sender.transport
    seen: list[object] = []
    watch_sender(sender, on_report=seen.append, on_key_frame=lambda: seen.append("key"))
    watch_rtcp(dtls, lambda: seen.append("rtcp"))
    date_by_capture(sender, lambda: 0.0)
    limit_gathering(dtls.transport)
    dtls._rtp_router.register_sender(sender, ssrc=sender._ssrc)
    about = RtcpReceiverInfo(
        ssrc=sender._ssrc, fraction_lost=64, packets_lost=3, highest_sequence=7, jitter=5, lsr=0, dlsr=0
    )
    await dtls._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1, reports=[about])))
    await dtls._handle_rtcp_data(bytes(RtcpPsfbPacket(fmt=RTCP_PSFB_PLI, ssrc=1, media_ssrc=sender._ssrc)))
    await connection.createOffer()
    ice = dtls.transport._connection
    checks = {
        "reports and key-frame requests do not arrive": seen == ["rtcp", ReceiverReport(7, 0.25, 3, 5), "rtcp", "key"],
        "RTCP does not pass through _handle_rtcp_data": "_handle_rtcp_data" in _names(RTCDtlsTransport._recv_next),
        "RTCP is not routed to _handle_rtcp_packet": "_handle_rtcp_packet"
        in _names(RTCDtlsTransport._handle_rtcp_data),
        "RTCP is routed in another way": callable(RtpRouter.route_rtcp),
        "reports are sent elsewhere": "_send_rtcp" in _names(RTCRtpSender._run_rtcp),
        "the last report is not remembered": hasattr(sender, _LAST_REPORT),
        "the negotiated codec is elsewhere": negotiated_codec(transceiver) is not None,
        "an unconnected ICE transport answers": not await ask_for_a_sign(dtls.transport),
        "ICE has no build_request": callable(ice.build_request),
        "gathering is elsewhere": "get_component_candidates" in _names(type(ice).gather_candidates),
    }
    return [difference for difference, holds in checks.items() if not holds]


def _names(function: Any) -> tuple[str, ...]:
    """The names that the code of `function` looks up, without running it."""
    names: tuple[str, ...] = function.__code__.co_names
    nested = [constant for constant in function.__code__.co_consts if hasattr(constant, "co_names")]
    return names + tuple(name for code in nested for name in code.co_names)
