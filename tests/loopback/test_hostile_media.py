"""An application sends what no other would: its streams go on, or end with a reason."""

import asyncio
import struct
from collections.abc import AsyncIterator
from contextlib import suppress

import pytest
from openrois_streaming.aiortc_internals.incoming import SOURCES_LIMIT
from openrois_streaming.network.admission import RTCP_PER_SECOND
from openrois_streaming.state import StreamStatus

from tests.loopback.test_uplinks import Ears, Talker
from tests.support import loopback

pytestmark = pytest.mark.media


@pytest.fixture
async def ears() -> AsyncIterator[Ears]:
    async with loopback.engine() as engine:
        yield Ears(engine)


@pytest.fixture
async def talker(ears: Ears) -> AsyncIterator[Talker]:
    talker = Talker(ears.engine)
    yield talker
    await talker.close()


def rtcp(kind: int, count: int, body: bytes) -> bytes:
    return struct.pack("!BBH", 0x80 | count, kind, len(body) // 4) + body


def rtp(payload_type: int, sequence: int, ssrc: int, *elements: bytes) -> bytes:
    """A packet with these one-byte header extensions."""
    block = b"".join(elements)
    block += bytes(-len(block) % 4)
    header = struct.pack("!BBHLLHH", 0x90, payload_type, sequence, 0, ssrc, 0xBEDE, len(block) // 4)
    return header + block + b"payload"


async def test_packets_that_cannot_be_read_end_nothing_and_sources_without_end_do(ears: Ears, talker: Talker) -> None:
    engine = ears.engine
    engine.connect("v", "video")
    ears.connect("cam", "video")
    for stream_id in ("v", "cam"):
        await engine.until(stream_id, StreamStatus.RUNNING)
    camera = talker.connections["engine/p1"].getTransceivers()[1]
    payload_type, dtls = camera._codecs[0].payloadType, camera.sender.transport
    assert payload_type is not None
    await dtls._send_rtp(rtcp(206, 15, struct.pack("!LL4sBBH", 1, 0, b"REMB", 200, 0, 0)))
    await dtls._send_rtp(rtcp(206, 1, bytes(4)))
    await dtls._send_rtp(rtcp(203, 31, bytes(4)))
    for number, extension in enumerate(camera._headerExtensions):
        await dtls._send_rtp(rtp(payload_type, number, 5, bytes((extension.id << 4,)) + b"\xff"))
    for first in (b"\x80\x60", b"\x80\xc9", b"\x16\xfe"):  # an eavesdropper can send these
        await dtls.transport._send(first + bytes(1600))
    await talker.plays("0", 30)
    assert engine.byes == []
    assert [engine.session.status(each) for each in ("v", "cam")] == [StreamStatus.RUNNING] * 2
    for ssrc in range(1, SOURCES_LIMIT + 10):
        await dtls._send_rtp(rtp(payload_type, 1, ssrc))
        if not ssrc % 100:  # so that none is lost
            await talker.plays("0", 1)
    await engine.news.until(lambda: engine.byes)
    assert engine.byes[0].reason == "the application sends from too many sources (SSRC)"


async def test_a_viewer_that_keeps_sending_reports_is_ended_with_a_reason(ears: Ears, talker: Talker) -> None:
    engine = ears.engine
    engine.connect("v", "video")
    await engine.until("v", StreamStatus.RUNNING)
    dtls = talker.connections["engine/p1"].getTransceivers()[0].sender.transport
    nack = rtcp(205, 1, struct.pack("!LLHH", 1, 2, 7, 0xFFFF))
    sent = 0

    async def flood() -> None:
        nonlocal sent
        while not engine.byes:
            for _ in range(RTCP_PER_SECOND // 10):
                with suppress(ConnectionError):  # the engine may have closed it just now
                    await dtls._send_rtp(nack)
                sent += 1
            await asyncio.sleep(0.02)

    await flood()
    assert [bye.reason for bye in engine.byes] == ["the application sends more packets than the engine admits"]
    assert 0 < engine.session.guarded.peer_limit <= sent - RTCP_PER_SECOND
    assert engine.session.guarded.total_limit == 0
