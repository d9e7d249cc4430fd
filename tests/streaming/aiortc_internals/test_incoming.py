import logging
import struct
from collections.abc import AsyncIterator

import pytest
from aiortc import RTCPeerConnection
from aiortc.rtcdtlstransport import RTCDtlsTransport
from aiortc.rtp import RtcpRrPacket, RtpPacket
from openrois_streaming.aiortc_internals.incoming import SOURCES_LIMIT, Incoming
from openrois_streaming.network.guard import GuardFigures


@pytest.fixture
async def transport() -> AsyncIterator[RTCDtlsTransport]:
    connection = RTCPeerConnection()
    yield connection.addTransceiver("video", direction="recvonly").receiver.transport
    await connection.close()


def limit_without_sources() -> bytes:
    """A REMB that names more sources than are in it."""
    body = struct.pack("!LL4sBBH", 1, 0, b"REMB", 200, 0, 0)
    return struct.pack("!BBH", 0x8F, 206, len(body) // 4) + body


async def test_parser_failures_are_contained_and_logged_once(
    transport: RTCDtlsTransport, caplog: pytest.LogCaptureFixture
) -> None:
    heard: list[str] = []
    figures = GuardFigures()
    with caplog.at_level(logging.INFO):
        Incoming(transport, lambda: heard.append("rtcp"), figures)
        for _ in range(3):
            await transport._handle_rtcp_data(limit_without_sources())
        await transport._handle_rtp_data(b"", arrival_time_ms=0)
        await transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1)))
    assert heard == ["rtcp"] * 4
    assert len(caplog.records) == 1
    assert figures == GuardFigures(unreadable=3)


async def test_a_callback_that_fails_does_not_reach_aiortc(
    transport: RTCDtlsTransport, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> None:
        raise RuntimeError("a mistake")

    Incoming(transport, fail, GuardFigures())
    with caplog.at_level(logging.INFO):
        await transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=1)))
    assert "a mistake" in caplog.text


async def test_an_application_with_sources_without_end_is_not_listened_to(transport: RTCDtlsTransport) -> None:
    heard: list[str] = []
    incoming = Incoming(transport, lambda: heard.append("rtcp"), GuardFigures())
    for ssrc in range(SOURCES_LIMIT):
        await transport._handle_rtp_data(RtpPacket(ssrc=ssrc).serialize(), arrival_time_ms=0)
    await transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=7)))
    assert (incoming.crowded, heard) == (False, ["rtcp"])
    await transport._handle_rtcp_data(bytes(RtcpRrPacket(ssrc=SOURCES_LIMIT)))
    await transport._handle_rtp_data(RtpPacket(ssrc=1).serialize(), arrival_time_ms=0)
    assert (incoming.crowded, heard) == (True, ["rtcp"])
