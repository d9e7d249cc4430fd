"""An RTP receiver of ours in the place of aiortc's, and the bit rate that its estimator finds.

What is reached for, and why nothing public does it:

* `RTCRtpReceiver.receive`, `.stop`, `._handle_rtp_packet`, `._handle_rtcp_packet` and `._handle_disconnect` are looked
  up on the instance: whoever stands there receives. aiortc's own has queues without bounds, decodes whether somebody
  reads or not, holds each picture back until the next one comes, and waits seconds for lost packets.
* `RTCDtlsTransport._register_rtp_receiver` and `._unregister_rtp_receiver` have packets routed; `._send_rtp` encrypts
  and sends RTCP; `RtpRouter.ssrc_table` grows with each source that somebody makes up.
* `RTCRtpSender._ssrc` is what a receiver is called in its reports.
* `aiortc.rate.RemoteBitrateEstimator` finds what a path carries.
"""

import contextlib
from typing import Any, Protocol

from aiortc import RTCRtpReceiver, RTCRtpTransceiver
from aiortc.rate import BandwidthUsage, RemoteBitrateEstimator
from aiortc.rtcdtlstransport import RTCDtlsTransport, RtpRouter
from aiortc.rtp import RtcpSrPacket, RtpPacket

from openrois_streaming.aiortc_internals.code import names_in
from openrois_streaming.receive.inbound import Arrived, Codec, Negotiated, SenderReport

_NTP_EPOCH = 2_208_988_800  # seconds from 1900 to 1970
# With less often added packets the estimator counts the milliseconds between them, one by one.
_PAUSE_MS = 2000


class ReceiverInPlace(Protocol):
    """What takes the place of an `RTCRtpReceiver`."""

    async def negotiated(self, parameters: Negotiated) -> None:
        """An answer says what comes; called again after later ones."""
        ...

    async def arrived(self, packet: Arrived) -> None:
        """A packet came."""
        ...

    def reported(self, report: SenderReport) -> None:
        """A sender report came."""
        ...

    def disconnected(self) -> None:
        """Nothing more will come."""
        ...

    async def stop(self) -> None:
        """The peer connection closes."""
        ...


def replace_receiver(transceiver: RTCRtpTransceiver, ours: ReceiverInPlace) -> None:
    """Let `ours` receive instead of the receiver of `transceiver`, which then only stands in the descriptions."""
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
    """The SSRC by which a receiver names itself in its reports: that of the sender beside it."""
    ssrc: int = transceiver.sender._ssrc
    return ssrc


async def send_rtcp(receiver: RTCRtpReceiver, packet: bytes) -> None:
    """Send an RTCP packet; lost where the transport is closed."""
    with contextlib.suppress(ConnectionError):
        await receiver.transport._send_rtp(packet)


def forget_source(receiver: RTCRtpReceiver, ssrc: int) -> None:
    """Do not remember any more where packets of `ssrc` go."""
    receiver.transport._rtp_router.ssrc_table.pop(ssrc, None)


class BitrateEstimate:
    """How much the path from one sender carries, by the delays between its packets (REMB)."""

    def __init__(self) -> None:
        self._estimator = RemoteBitrateEstimator()
        self._last = 0

    def add(self, packet: Arrived, arrival: float) -> tuple[int, bool] | None:
        """A packet came at `arrival` (seconds); returns an estimate when there is a new one.

        That is how much comes (bit/s), or less than that where the path is full, and whether it is.
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
    """What is not as this module expects it, tried on a video transceiver that is used for nothing else."""
    receiver: Any = transceiver.receiver
    # Its own methods, before they are replaced.
    checks = {
        f"a receiver has no {name}": callable(getattr(receiver, name, None))
        for name in ("receive", "stop", "_handle_rtp_packet", "_handle_rtcp_packet", "_handle_disconnect")
    }
    checks |= {
        "RTP is not routed to _handle_rtp_packet": "_handle_rtp_packet" in names_in(RTCDtlsTransport._handle_rtp_data),
        "receivers are not told of the end": "_handle_disconnect" in names_in(RTCDtlsTransport._RTCDtlsTransport__run),  # type: ignore[attr-defined]
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
    """A receiver that only looks."""

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
