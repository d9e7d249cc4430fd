import logging
import socket
from collections.abc import AsyncIterator, Callable, Sequence
from types import SimpleNamespace
from typing import Any

import pytest
from aiortc import RTCPeerConnection
from aiortc.rtcdtlstransport import RTCDtlsTransport, State
from aiortc.rtcrtpparameters import (
    RTCRtcpParameters,
    RTCRtpCodecParameters,
    RTCRtpHeaderExtensionParameters,
    RTCRtpSendParameters,
)
from aiortc.rtcrtpsender import RTCRtpSender
from aiortc.rtp import (
    RTCP_PSFB_APP,
    RTCP_PSFB_FIR,
    RTCP_PSFB_PLI,
    RTCP_RTPFB_NACK,
    RtcpByePacket,
    RtcpPacket,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    pack_remb_fci,
)
from openrois_streaming.aiortc_internals import sending
from openrois_streaming.aiortc_internals.sending import DtlsWire, take_over
from openrois_streaming.aiortc_internals.srtp import Protection
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary, self_test
from openrois_streaming.rtp.extensions import ABS_SEND_TIME, MID
from openrois_streaming.rtp.reports import ReceiverReport

from tests.support.sending import Sending, picture

PARAMETERS = RTCRtpSendParameters(
    codecs=[
        RTCRtpCodecParameters(mimeType="video/VP8", clockRate=90_000, payloadType=97),
        RTCRtpCodecParameters(mimeType="video/rtx", clockRate=90_000, payloadType=100, parameters={"apt": 99}),
        RTCRtpCodecParameters(mimeType="video/rtx", clockRate=90_000, payloadType=98, parameters={"apt": 97}),
    ],
    headerExtensions=[
        RTCRtpHeaderExtensionParameters(id=1, uri=MID),
        RTCRtpHeaderExtensionParameters(id=3, uri=ABS_SEND_TIME),
    ],
    muxId="0",
    rtcp=RTCRtcpParameters(cname="name"),
)


class Open(Protection):
    """A cipher that changes nothing."""

    def rtp(self, packets: Sequence[bytes]) -> list[bytes]:
        return [b"rtp:" + packet for packet in packets]

    def rtcp(self, packet: bytes) -> bytes:
        return b"rtcp:" + packet


class Datagrams:
    """A DTLS transport's connected state, over a relay or over a socket; it keeps what leaves over a relay."""

    def __init__(self, dtls: RTCDtlsTransport, address: tuple[str, int] = ("192.0.2.1", 5000)) -> None:
        self.sent: list[tuple[bytes, tuple[str, int]]] = []
        self.socket: socket.socket | None = None
        self._dtls = dtls
        transport = SimpleNamespace(
            sendto=lambda *sent: self.sent.append(sent), get_extra_info=lambda name: getattr(self, name)
        )
        pair: Any = SimpleNamespace(protocol=SimpleNamespace(transport=transport), remote_addr=address)
        dtls.transport._connection._nominated[1] = pair
        dtls._tx_srtp = object()  # type: ignore[assignment]
        dtls._state = State.CONNECTED

    def close(self) -> None:
        """As ICE and DTLS do."""
        self._dtls.transport._connection._nominated.clear()
        self._dtls._state = State.CLOSED


class Replaced:
    """A sender of aiortc's, with ours in its place."""

    def __init__(self) -> None:
        self.connection = RTCPeerConnection()
        self.aiortc = self.connection.addTransceiver("video", direction="sendonly").sender
        self.ours = Sending()
        self.wire = DtlsWire()
        take_over(self.aiortc, self.ours.sender, self.wire)

    async def hear(self, packet: Any) -> None:
        """Let a packet of the other end come, decrypted."""
        await self.aiortc.transport._handle_rtcp_data(bytes(packet))


@pytest.fixture
async def replaced(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Replaced]:
    monkeypatch.setattr(sending, "Protection", Open)
    replaced = Replaced()
    yield replaced
    await replaced.connection.close()
    replaced.wire.close()


async def test_sender_sends_from_negotiation_until_the_end(replaced: Replaced) -> None:
    datagrams = Datagrams(replaced.aiortc.transport)
    await replaced.aiortc.send(PARAMETERS)
    await replaced.aiortc.send(PARAMETERS)
    replaced.ours.sender.send(picture(0, keyframe=True))
    (packet, address), (report, _) = datagrams.sent
    assert address == ("192.0.2.1", 5000)
    assert (packet[:4], packet[5] & 0x7F, packet[12:16]) == (b"rtp:", 97, replaced.aiortc._ssrc.to_bytes(4, "big"))
    assert report.startswith(b"rtcp:")
    await replaced.aiortc.stop()
    assert isinstance(RtcpPacket.parse(datagrams.sent[-1][0][5:])[-1], RtcpByePacket)
    await replaced.hear(RtcpPsfbPacket(fmt=RTCP_PSFB_PLI, ssrc=1, media_ssrc=replaced.aiortc._ssrc))
    assert replaced.ours.requests == 0, "its reports are no longer routed"
    datagrams.close()


async def test_requested_packets_come_again_over_rtx(replaced: Replaced) -> None:
    datagrams = Datagrams(replaced.aiortc.transport)
    await replaced.aiortc.send(PARAMETERS)
    replaced.ours.sender.send(picture(0, keyframe=True))
    sequence = int.from_bytes(datagrams.sent[0][0][6:8], "big")
    ssrc = replaced.aiortc._ssrc
    await replaced.hear(RtcpRtpfbPacket(fmt=RTCP_RTPFB_NACK, ssrc=1, media_ssrc=ssrc, lost=[sequence]))
    again = datagrams.sent[-1][0]
    assert (again[5] & 0x7F, again[12:16]) == (98, replaced.aiortc._rtx_ssrc.to_bytes(4, "big"))
    datagrams.close()


async def test_viewer_reports_reach_the_listener(replaced: Replaced) -> None:
    ssrc = replaced.aiortc._ssrc

    def about(ssrc: int) -> RtcpReceiverInfo:
        return RtcpReceiverInfo(
            ssrc=ssrc, fraction_lost=128, packets_lost=5, highest_sequence=70_000, jitter=90, lsr=0, dlsr=0
        )

    replaced.aiortc.transport._rtp_router.register_sender(replaced.aiortc, ssrc=ssrc)
    await replaced.hear(RtcpRrPacket(ssrc=1, reports=[about(ssrc ^ 1), about(ssrc)]))
    for request in (RTCP_PSFB_PLI, RTCP_PSFB_FIR):
        await replaced.hear(RtcpPsfbPacket(fmt=request, ssrc=1, media_ssrc=ssrc))
    await replaced.hear(RtcpPsfbPacket(fmt=RTCP_PSFB_APP, ssrc=1, media_ssrc=0, fci=pack_remb_fci(800_000, [ssrc, 5])))
    assert replaced.ours.reports == [ReceiverReport(70_000, 0.5, 5, 90)]
    assert replaced.ours.requests == 2
    assert replaced.ours.estimates == [800_000]


async def test_a_report_that_cannot_be_read_does_not_reach_aiortc(
    replaced: Replaced, caplog: pytest.LogCaptureFixture
) -> None:
    ssrc = replaced.aiortc._ssrc
    replaced.aiortc.transport._rtp_router.register_sender(replaced.aiortc, ssrc=ssrc)
    with caplog.at_level(logging.ERROR):
        await replaced.hear(RtcpPsfbPacket(fmt=RTCP_PSFB_APP, ssrc=1, media_ssrc=ssrc, fci=b"AFB?"))
    assert "could not be handled" in caplog.text
    assert replaced.ours.estimates == []


async def test_a_closed_way_takes_everything_and_sends_nothing(replaced: Replaced) -> None:
    wire = replaced.wire
    wire.send([b"packet"])
    wire.open(replaced.aiortc.transport)
    wire.send_report(b"report")
    datagrams = Datagrams(replaced.aiortc.transport)
    replaced.aiortc.transport._state = State.CONNECTING
    wire.send([b"packet"])
    replaced.aiortc.transport._state = State.CONNECTED
    replaced.aiortc.transport.transport._connection._nominated.clear()
    wire.send([b"packet"])
    assert datagrams.sent == []
    datagrams.close()


async def test_over_a_socket_packets_leave_through_a_handle_of_its_own(replaced: Replaced) -> None:
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as here,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as there,
    ):
        there.bind(("127.0.0.1", 0))
        there.settimeout(5)
        for each in (Datagrams(replaced.aiortc.transport, there.getsockname()) for _ in range(2)):
            each.socket = here
            replaced.wire.open(replaced.aiortc.transport)
            replaced.wire.send([b"one", b"two"])
            assert [there.recv(100), there.recv(100)] == [b"rtp:one", b"rtp:two"]
            assert each.sent == []
        replaced.wire.close()
        replaced.wire.send([b"three"])
        each.close()


def renamed(monkeypatch: pytest.MonkeyPatch) -> None:
    async def send(self: RTCRtpSender, parameters: object) -> None: ...

    monkeypatch.setattr(RTCRtpSender, "send", send)


def encrypted_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    async def send(self: RTCDtlsTransport, data: bytes) -> None: ...

    monkeypatch.setattr(RTCDtlsTransport, "_send_rtp", send)


def routed_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    async def handle(self: RTCDtlsTransport, data: bytes) -> None: ...

    monkeypatch.setattr(RTCDtlsTransport, "_handle_rtcp_data", handle)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (renamed, "senders are registered otherwise"),
        (encrypted_elsewhere, "packets are encrypted otherwise"),
        (routed_elsewhere, "reports do not arrive"),
    ],
)
async def test_a_changed_library_is_refused(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[pytest.MonkeyPatch], None], told: str
) -> None:
    change(monkeypatch)
    with pytest.raises(UnsupportedLibrary, match=told):
        await self_test()
