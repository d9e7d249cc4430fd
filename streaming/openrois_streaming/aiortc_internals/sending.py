"""Our sender in place of aiortc's, which keeps the negotiation: SSRCs, payload types, mid.

Private names in use, and why no public one does it:

* `RTCRtpSender.send`, `.stop` and `._handle_rtcp_packet` are looked up on the instance, so that ours can replace them,
and get the negotiated parameters, the end, and reports. There is no other way to get the first.
* `RTCDtlsTransport._register_rtp_sender` and `._unregister_rtp_sender` have reports routed.
* `HEADER_EXTENSIONS` of `aiortc.codecs` is the list for all offers and answers; there is no other way to negotiate one.
* `RTCDtlsTransport._tx_srtp` encrypts, `._state` says whether the other end is connected; `RTCIceTransport._connection`
  has the pair that ICE chose, and so a socket. aiortc passes each packet through a chain of coroutines.
"""

import asyncio
import logging
import os
from collections.abc import Sequence
from typing import Any, Final

from aioice.ice import Connection, StunProtocol
from aiortc import RTCPeerConnection, RTCRtpSender, RTCRtpTransceiver
from aiortc.codecs import HEADER_EXTENSIONS, is_rtx
from aiortc.rtcdtlstransport import RTCDtlsTransport, State
from aiortc.rtcrtpparameters import RTCRtpHeaderExtensionParameters, RTCRtpSendParameters
from aiortc.rtp import (
    RTCP_PSFB_APP,
    RTCP_PSFB_FIR,
    RTCP_PSFB_PLI,
    RTCP_RTPFB_NACK,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSrPacket,
    pack_remb_fci,
    unpack_remb_fci,
)

from openrois_streaming.aiortc_internals import names_in, srtp
from openrois_streaming.aiortc_internals.srtp import Protection
from openrois_streaming.clock import SystemClock
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.rtp.extensions import ABS_CAPTURE_TIME, ABS_SEND_TIME, MID, PLAYOUT_DELAY
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.bursts import BurstSocket
from openrois_streaming.send.pacer import Outlet
from openrois_streaming.send.sender import Negotiated, RtpSender

_COMPONENT: Final = 1  # of ICE: RTP and RTCP share it (RFC 5761)

# Ids are the same in all sections of a bundle; aiortc's own end at 3.
_OURS: Final = {PLAYOUT_DELAY: 4, ABS_CAPTURE_TIME: 5}
for _uri, _id in _OURS.items():
    if all(each.uri != _uri for each in HEADER_EXTENSIONS["video"]):
        HEADER_EXTENSIONS["video"].append(RTCRtpHeaderExtensionParameters(id=_id, uri=_uri))

_log = logging.getLogger(__name__)


class _Way:
    """Path over one pair of addresses that ICE has chosen. To be closed."""

    __slots__ = ("_address", "_burst", "_transport", "pair", "protection")

    def __init__(self, pair: Any, protection: Protection) -> None:
        self.pair = pair
        self.protection = protection
        self._address: tuple[str, int] = pair.remote_addr
        self._transport = pair.protocol.transport
        opened = self._transport.get_extra_info("socket")  # a relay has none of its own
        self._burst = None if opened is None else BurstSocket(os.dup(opened.fileno()), opened.family)

    def leave(self, datagrams: Sequence[bytes]) -> None:
        """Send protected packets."""
        if self._burst is not None:
            self._burst.send(datagrams, self._address)
        else:
            for datagram in datagrams:
                self._transport.sendto(datagram, self._address)

    def close(self) -> None:
        """Close the path."""
        if self._burst is not None:
            self._burst.close()


class DtlsWire:
    """Encrypted path over a DTLS transport; packets that cannot leave at once are lost. To be closed."""

    def __init__(self) -> None:
        self._dtls: RTCDtlsTransport | None = None
        self._way: _Way | None = None

    def open(self, dtls: RTCDtlsTransport) -> None:
        """Open the path over `dtls`, the only transport it ever has."""
        self._dtls = dtls

    def send(self, packets: Sequence[bytes]) -> None:
        """Protect and send RTP packets.

        Raises:
            pylibsrtp.Error: a packet cannot be protected.
        """
        way = self._present()
        if way is not None:
            way.leave(way.protection.rtp(packets))

    def send_report(self, packet: bytes) -> None:
        """Protect and send one compound RTCP packet.

        Raises:
            pylibsrtp.Error: it cannot be protected.
        """
        way = self._present()
        if way is not None:
            way.leave([way.protection.rtcp(packet)])

    def close(self) -> None:
        """Close the path for good."""
        self._dtls = None
        self._replace_way(None)

    def _present(self) -> _Way | None:
        dtls = self._dtls
        if dtls is None or dtls._state is not State.CONNECTED:
            return None
        pair = dtls.transport._connection._nominated.get(_COMPONENT)
        if pair is None:
            return None
        if self._way is None or self._way.pair is not pair:
            self._replace_way(_Way(pair, Protection(dtls._tx_srtp)))
        return self._way

    def _replace_way(self, way: _Way | None) -> None:
        if self._way is not None:
            self._way.close()
        self._way = way


def take_over(replaced: RTCRtpSender, sender: RtpSender, wire: DtlsWire) -> None:
    """Replace `replaced` by `sender`, over `wire`, from its negotiation until its end."""
    started = False

    async def send(parameters: RTCRtpSendParameters) -> None:
        nonlocal started
        if not started:  # aiortc calls it after each answer
            started = True
            replaced.transport._register_rtp_sender(replaced, parameters)
            wire.open(replaced.transport)
            sender.start(_negotiated(replaced, parameters), wire)

    async def stop() -> None:
        replaced.transport._unregister_rtp_sender(replaced)
        sender.stop()

    async def handle(packet: Any) -> None:
        try:
            _dispatch_rtcp(sender, replaced._ssrc, packet)
        except Exception:  # in aiortc's receiving loop it would end the peer connection
            _log.exception("a report could not be handled")

    replaced.send = send  # type: ignore[method-assign]
    replaced.stop = stop  # type: ignore[method-assign]
    replaced._handle_rtcp_packet = handle  # type: ignore[method-assign]


async def differences(connection: RTCPeerConnection) -> list[str]:
    """Return the differences from what this module relies on, tried on `connection`; opens no socket."""
    replaced = connection.addTransceiver("video", direction="sendonly").sender
    dtls, recorder = replaced.transport, _Recorder()
    outlet = Outlet.made(SystemClock(), 0.0, asyncio.get_running_loop().call_later)
    take_over(replaced, RtpSender("video", recorder, outlet), DtlsWire())
    dtls._rtp_router.register_sender(replaced, ssrc=replaced._ssrc)
    about = RtcpReceiverInfo(
        ssrc=replaced._ssrc, fraction_lost=64, packets_lost=3, highest_sequence=7, jitter=5, lsr=0, dlsr=0
    )
    await dtls._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1, reports=[about])))
    await dtls._handle_rtcp_data(bytes(RtcpPsfbPacket(fmt=RTCP_PSFB_PLI, ssrc=1, media_ssrc=replaced._ssrc)))
    remb = pack_remb_fci(1_000_000, [replaced._ssrc])
    await dtls._handle_rtcp_data(bytes(RtcpPsfbPacket(fmt=RTCP_PSFB_APP, ssrc=1, media_ssrc=0, fci=remb)))
    nack = RtcpRtpfbPacket.parse(bytes(RtcpRtpfbPacket(fmt=RTCP_RTPFB_NACK, ssrc=1, media_ssrc=2, lost=[7, 9]))[4:], 1)
    offered = (await connection.createOffer()).sdp
    checks = {
        "an extension is not offered": all(f"a=extmap:{id_} {uri}" in offered for uri, id_ in _OURS.items())
        and len({each.id for kind in HEADER_EXTENSIONS.values() for each in kind}) == max(_OURS.values()),
        "reports do not arrive": recorder.events == [ReceiverReport(7, 0.25, 3, 5), "key frame", 1_000_000],
        "requests for packets are parsed otherwise": nack.lost == [7, 9],
        "senders are started otherwise": "send" in names_in(RTCPeerConnection._RTCPeerConnection__connect),  # type: ignore[attr-defined]
        "senders are stopped otherwise": "stop" in names_in(RTCRtpTransceiver.stop),
        "senders are registered otherwise": {"_register_rtp_sender", "_rtx_ssrc"}
        <= {*names_in(RTCRtpSender.send), *names_in(RTCRtpSender._retransmit)},
        "senders are not unregistered": "_unregister_rtp_sender" in names_in(RTCRtpSender.stop),
        "packets are encrypted otherwise": {"_state", "_tx_srtp", "protect", "protect_rtcp"}
        <= set(names_in(RTCDtlsTransport._send_rtp)),
        "packets leave otherwise": {"_nominated", "remote_addr", "protocol"} <= set(names_in(Connection.sendto))
        and {"transport", "sendto"} <= set(names_in(StunProtocol.send_data)),
    }
    return [difference for difference, holds in checks.items() if not holds] + srtp.differences()


class _Recorder:
    """Listener that records the events of a sender."""

    def __init__(self) -> None:
        self.events: list[object] = []

    def sent(self, frame: EncodedFrame) -> None:
        self.events.append(frame)

    def left_out(self, frames: int, *, repair: bool) -> None:
        self.events.append(frames)

    def reported(self, report: ReceiverReport) -> None:
        self.events.append(report)

    def estimated(self, bitrate: int) -> None:
        self.events.append(bitrate)

    def key_frame_wanted(self) -> None:
        self.events.append("key frame")


def _negotiated(replaced: RTCRtpSender, parameters: RTCRtpSendParameters) -> Negotiated:
    codec = parameters.codecs[0]
    assert codec.payloadType is not None, "a negotiated codec has a payload type"
    repeating = [
        each.payloadType
        for each in parameters.codecs
        if is_rtx(each) and each.parameters.get("apt") == codec.payloadType
    ]
    ids = {extension.uri: extension.id for extension in parameters.headerExtensions}
    return Negotiated(
        ssrc=replaced._ssrc,
        payload_type=codec.payloadType,
        rtx_ssrc=replaced._rtx_ssrc,
        rtx_payload_type=repeating[0] if repeating else None,
        cname=parameters.rtcp.cname or "",
        mid=parameters.muxId,
        mid_id=ids.get(MID),
        abs_send_time_id=ids.get(ABS_SEND_TIME),
        playout_delay_id=ids.get(PLAYOUT_DELAY),
        capture_time_id=ids.get(ABS_CAPTURE_TIME),
    )


def _dispatch_rtcp(sender: RtpSender, ssrc: int, packet: Any) -> None:
    match packet:
        case RtcpRrPacket() | RtcpSrPacket():
            for each in packet.reports:
                if each.ssrc == ssrc:
                    sender.reported(_report(each), each.lsr, each.dlsr)
        case RtcpRtpfbPacket(fmt=fmt) if fmt == RTCP_RTPFB_NACK:
            sender.missed(packet.lost)
        case RtcpPsfbPacket(fmt=fmt) if fmt in (RTCP_PSFB_PLI, RTCP_PSFB_FIR):
            sender.undecodable()
        case RtcpPsfbPacket(fmt=fmt) if fmt == RTCP_PSFB_APP:
            sender.estimated(unpack_remb_fci(packet.fci)[0])


def _report(about: RtcpReceiverInfo) -> ReceiverReport:
    return ReceiverReport(about.highest_sequence, about.fraction_lost / 256, about.packets_lost, about.jitter)
