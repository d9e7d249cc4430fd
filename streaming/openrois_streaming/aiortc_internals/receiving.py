"""Our RTP receiver in place of aiortc's, and aiortc's estimator of the bit rate.

Private names in use, and why no public one does it:

* `RTCRtpReceiver.receive`, `.stop`, `._handle_rtp_packet`, `._handle_rtcp_packet` and `._handle_disconnect` are looked
up on the instance, so that ours can replace them. aiortc's own has unbounded queues, decodes also without a reader,
holds each picture back until the next one comes, and waits seconds for lost packets.
* `RTCDtlsTransport._register_rtp_receiver` and `._unregister_rtp_receiver` have packets routed; `._send_rtp` encrypts
  and sends RTCP; `RtpRouter.ssrc_table` grows with each invented source.
* `RTCRtpSender._ssrc` names a receiver in its reports.
* `aiortc.rate.RemoteBitrateEstimator` estimates the bit rate of a path.
"""

import contextlib
from typing import Any, Protocol

from aiortc import RTCRtpReceiver, RTCRtpTransceiver
from aiortc.rate import BandwidthUsage, RemoteBitrateEstimator
from aiortc.rtcdtlstransport import RTCDtlsTransport, RtpRouter
from aiortc.rtp import RtcpSrPacket, RtpPacket

from openrois_streaming.aiortc_internals import names_in
from openrois_streaming.receive.inbound import Arrived, Codec, Negotiated, SenderReport

_NTP_EPOCH = 2_208_988_800  # seconds from 1900 to 1970
# With rarer packets the estimator counts the milliseconds between them, one by one.
_PAUSE_MS = 2000


class ReceiverInPlace(Protocol):
    """Replacement of an `RTCRtpReceiver`."""

    async def negotiated(self, parameters: Negotiated) -> None:
        """Apply the parameters of an answer; called after each answer."""
        ...

    async def arrived(self, packet: Arrived) -> None:
        """Receive a packet."""
        ...

    def reported(self, report: SenderReport) -> None:
        """Apply a sender report."""
        ...

    def disconnected(self) -> None:
        """End the source: the transport is disconnected."""
        ...

    async def stop(self) -> None:
        """Stop with the peer connection."""
        ...


def replace_receiver(transceiver: RTCRtpTransceiver, ours: ReceiverInPlace) -> None:
    """Replace the receiver of `transceiver` by `ours`; the former then only appears in descriptions."""
    receiver: Any = transceiver.receiver

    async def receive(parameters: Any) -> None:
        await ours.negotiated(_negotiated(parameters))
        receiver.transport._unregister_rtp_receiver(receiver)  # what an earlier answer announced
        receiver.transport._register_rtp_receiver(receiver, parameters)

    async def handle_rtp(packet: RtpPacket, arrival_time_ms: int) -> None:
        await ours.arrived(
            Arrived(
                packet.payload_type,
                packet.sequence_number,
                packet.timestamp,
                bool(packet.marker),
                packet.ssrc,
                packet.payload,
                packet.extensions.abs_send_time,
                len(packet.payload) + packet.padding_size,
            )
        )

    async def handle_rtcp(packet: Any) -> None:
        if isinstance(packet, RtcpSrPacket):
            ntp = packet.sender_info.ntp_timestamp
            moment = ntp / 2**32 - _NTP_EPOCH
            ours.reported(SenderReport(packet.ssrc, ntp, moment, packet.sender_info.rtp_timestamp))

    async def stop() -> None:
        receiver.transport._unregister_rtp_receiver(receiver)
        await ours.stop()

    receiver.receive, receiver.stop = receive, stop
    receiver._handle_rtp_packet, receiver._handle_rtcp_packet = handle_rtp, handle_rtcp
    receiver._handle_disconnect = ours.disconnected


def _negotiated(parameters: Any) -> Negotiated:
    codecs = []
    for each in parameters.codecs:
        apt = each.parameters.get("apt")
        codecs.append(Codec(each.payloadType, each.mimeType, each.clockRate, apt if isinstance(apt, int) else None))
    repairs = {each.rtx.ssrc: each.ssrc for each in parameters.encodings if each.rtx}
    return Negotiated(codecs, [each.ssrc for each in parameters.encodings], repairs)


def own_ssrc(transceiver: RTCRtpTransceiver) -> int:
    """Return the SSRC that names a receiver in its reports: that of the sender beside it."""
    ssrc: int = transceiver.sender._ssrc
    return ssrc


async def send_rtcp(receiver: RTCRtpReceiver, packet: bytes) -> None:
    """Send an RTCP packet; it is lost if the transport is closed."""
    with contextlib.suppress(ConnectionError):
        await receiver.transport._send_rtp(packet)


def forget_source(receiver: RTCRtpReceiver, ssrc: int) -> None:
    """Remove `ssrc` from the routing table."""
    receiver.transport._rtp_router.ssrc_table.pop(ssrc, None)


class BitrateEstimate:
    """Estimate of the bit rate of the path from one sender, by the delays of its packets (REMB)."""

    def __init__(self) -> None:
        self._estimator = RemoteBitrateEstimator()
        self._last = 0

    def add(self, packet: Arrived, arrival: float) -> tuple[int, bool] | None:
        """Add a packet that came at `arrival` (seconds); returns an estimate when there is a new one.

        The estimate is the arriving bit/s, or less if the path is full, and whether it is full.
        """
        if packet.send_time is None:
            return None
        now = int(arrival * 1000)
        if not 0 <= now - self._last <= _PAUSE_MS:
            self._estimator = RemoteBitrateEstimator()
        self._last = now
        found = self._estimator.add(now, packet.send_time, packet.size, 0)
        return None if found is None else (found[0], self._estimator.detector.state() is BandwidthUsage.OVERUSING)


async def differences(transceiver: RTCRtpTransceiver) -> list[str]:
    """Return the differences from what this module relies on, tried on an otherwise unused video transceiver."""
    receiver: Any = transceiver.receiver
    # The receiver's own methods, before they are replaced.
    checks = {
        f"a receiver has no {name}": callable(getattr(receiver, name, None))
        for name in ("receive", "stop", "_handle_rtp_packet", "_handle_rtcp_packet", "_handle_disconnect")
    }
    checks |= {
        "RTP is not routed to _handle_rtp_packet": "_handle_rtp_packet" in names_in(RTCDtlsTransport._handle_rtp_data),
        "receivers do not learn of the end": "_handle_disconnect" in names_in(RTCDtlsTransport._RTCDtlsTransport__run),  # type: ignore[attr-defined]
        "receivers are registered elsewhere": "_register_rtp_receiver" in names_in(RTCRtpReceiver.receive),
        "receivers are unregistered elsewhere": "_unregister_rtp_receiver" in names_in(RTCRtpReceiver.stop),
        "RTCP is sent elsewhere": "_send_rtp" in names_in(RTCRtpReceiver._send_rtcp),
        "sources are remembered elsewhere": RtpRouter().ssrc_table == {},
    }
    seen = _Seen()
    replace_receiver(transceiver, seen)
    transport = receiver.transport
    await receiver.receive(_Parameters())
    await transport._handle_rtp_data(RtpPacket(payload_type=97, sequence_number=7, ssrc=9, payload=b"x").serialize(), 0)
    checks["packets do not arrive"] = [(each.sequence, each.payload) for each in seen.packets] == [(7, b"x")]
    checks["sources are not remembered"] = 9 in transport._rtp_router.ssrc_table
    await receiver.stop()
    checks["a receiver is not stopped"] = seen.stopped and receiver not in transport._rtp_router.receivers
    estimate = BitrateEstimate()
    found = [estimate.add(Arrived(97, n, n, True, 9, b"", n * 2621, 1000), n / 100) for n in range(600)]
    checks["no bit rate is estimated"] = any(found)
    return [difference for difference, holds in checks.items() if not holds]


class _Parameters:
    codecs = (type("Codec", (), {"payloadType": 97, "mimeType": "video/VP8", "clockRate": 90000, "parameters": {}})(),)
    encodings = ()
    headerExtensions = ()  # noqa: N815 - aiortc's name
    muxId = ""  # noqa: N815 - aiortc's name


class _Seen:
    """Receiver that records its packets."""

    def __init__(self) -> None:
        self.packets: list[Arrived] = []
        self.stopped = False

    async def negotiated(self, parameters: Negotiated) -> None:
        pass

    async def arrived(self, packet: Arrived) -> None:
        self.packets.append(packet)

    def reported(self, report: SenderReport) -> None:
        pass

    def disconnected(self) -> None:
        pass

    async def stop(self) -> None:
        self.stopped = True
