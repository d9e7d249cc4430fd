import logging
from collections.abc import Callable

import pytest
from aiortc import RTCPeerConnection
from aiortc.rtcdtlstransport import RTCDtlsTransport
from aiortc.rtcrtpsender import RTCRtpSender
from aiortc.rtp import (
    RTCP_PSFB_FIR,
    RTCP_PSFB_PLI,
    RtcpByePacket,
    RtcpPacket,
    RtcpPsfbPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpSenderInfo,
    RtcpSrPacket,
)
from openrois_streaming import aiortc_seams
from openrois_streaming.aiortc_seams import (
    ReceiverReport,
    UnsupportedLibrary,
    date_by_capture,
    self_test,
    watch_rtcp,
    watch_sender,
)


async def test_the_installed_libraries_are_as_expected() -> None:
    await self_test()


@pytest.mark.parametrize("name", ["aiortc", "aioice"])
async def test_another_version_is_refused(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setitem(aiortc_seams.TESTED, name, "0.1.")
    with pytest.raises(UnsupportedLibrary, match=rf"{name} .* is installed; tested are 0\.1\.\*"):
        await self_test()


def renamed(monkeypatch: pytest.MonkeyPatch) -> None:
    handle = RTCRtpSender._handle_rtcp_packet
    monkeypatch.delattr(RTCRtpSender, "_handle_rtcp_packet")
    monkeypatch.setattr(RTCRtpSender, "_handle_rtcp", handle, raising=False)


def key_frames_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    async def handle(self: RTCRtpSender, packet: object) -> None:
        pass

    monkeypatch.setattr(RTCRtpSender, "_handle_rtcp_packet", handle)


def received_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    async def receive(self: RTCDtlsTransport) -> None:
        pass

    monkeypatch.setattr(RTCDtlsTransport, "_recv_next", receive)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (renamed, "_handle_rtcp_packet"),
        (key_frames_elsewhere, "key-frame requests do not arrive"),
        (received_elsewhere, "RTCP does not pass through"),
    ],
)
async def test_a_changed_library_is_refused(
    monkeypatch: pytest.MonkeyPatch, change: Callable[[pytest.MonkeyPatch], None], told: str
) -> None:
    change(monkeypatch)
    with pytest.raises(UnsupportedLibrary, match=told):
        await self_test()


async def test_reports_and_requests_about_a_sender_are_told() -> None:
    connection = RTCPeerConnection()
    sender = connection.addTransceiver("video", direction="sendonly").sender
    reports: list[ReceiverReport] = []
    requests: list[None] = []
    watch_sender(sender, on_report=reports.append, on_key_frame=lambda: requests.append(None))

    def about(ssrc: int) -> RtcpReceiverInfo:
        return RtcpReceiverInfo(
            ssrc=ssrc, fraction_lost=128, packets_lost=5, highest_sequence=70_000, jitter=90, lsr=0, dlsr=0
        )

    await sender._handle_rtcp_packet(RtcpRrPacket(ssrc=1, reports=[about(sender._ssrc), about(sender._ssrc ^ 1)]))
    await sender._handle_rtcp_packet(RtcpRrPacket(ssrc=1, reports=[]))
    assert reports == [ReceiverReport(highest_sequence=70_000, fraction_lost=0.5, packets_lost=5, jitter=90)]
    for request in (RTCP_PSFB_PLI, RTCP_PSFB_FIR):
        await sender._handle_rtcp_packet(RtcpPsfbPacket(fmt=request, ssrc=1, media_ssrc=sender._ssrc))
    assert len(requests) == 2
    await connection.close()


async def test_reports_are_dated_by_capture_and_still_give_the_round_trip_time() -> None:
    connection = RTCPeerConnection()
    sender = connection.addTransceiver("video", direction="sendonly").sender
    sent: list[bytes] = []

    async def send(data: bytes) -> None:
        sent.append(data)

    sender.transport._send_rtp = send  # type: ignore[method-assign]
    moments = iter([None, 1_000_000.5])
    date_by_capture(sender, lambda: next(moments))
    info = RtcpSenderInfo(ntp_timestamp=7, rtp_timestamp=90, packet_count=1, octet_count=1)
    for _ in range(2):
        await sender._send_rtcp([RtcpSrPacket(ssrc=sender._ssrc, sender_info=info), RtcpByePacket(sources=[1])])
    first, second = (RtcpPacket.parse(data)[0] for data in sent)
    assert isinstance(first, RtcpSrPacket)
    assert isinstance(second, RtcpSrPacket)
    assert first.sender_info.ntp_timestamp == 7
    dated = int((1_000_000.5 + 2_208_988_800) * 2**32)
    assert (second.sender_info.ntp_timestamp, second.sender_info.rtp_timestamp) == (dated, 90)
    assert getattr(sender, "_RTCRtpSender__lsr") == dated >> 16 & 0xFFFFFFFF  # noqa: B009 - its name is mangled
    await connection.close()


async def test_a_callback_that_fails_does_not_reach_aiortc(caplog: pytest.LogCaptureFixture) -> None:
    connection = RTCPeerConnection()
    transport = connection.addTransceiver("video", direction="sendonly").sender.transport

    def fail() -> None:
        raise RuntimeError("a mistake")

    watch_rtcp(transport, fail)
    with caplog.at_level(logging.ERROR):
        await transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1)))
    assert "a mistake" in caplog.text
    await connection.close()
