import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from typing import Any

import pytest
from aiortc import RTCPeerConnection
from openrois_streaming.clock import SystemClock
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.receive.inbound import Negotiated
from openrois_streaming.source.source import RawAudio, RawVideo

from tests.support.receiving import Uplink, uplink

pytestmark = pytest.mark.media

PATIENCE = 15.0


async def some(frames: AsyncIterator[Any], count: int) -> list[Any]:
    async with asyncio.timeout(PATIENCE):
        return [await anext(frames) for _ in range(count)]


async def until(so: Callable[[], bool]) -> None:
    async with asyncio.timeout(PATIENCE):
        while not so():  # noqa: ASYNC110 - unread packets are not notified
            await asyncio.sleep(0.01)


async def until_frames(way: Uplink, count: int) -> None:
    await until(lambda: min(way.video.frames, way.audio.frames) >= count)


@pytest.mark.parametrize("codec", ["video/H264", "video/VP8"])
async def test_sent_media_can_be_read(codec: str) -> None:
    async with uplink(codec) as way:
        await until_frames(way, 5)
        assert way.video.figures.frames_decoded == way.audio.figures.frames_decoded == 0
        assert not [each for each in threading.enumerate() if each.name.startswith("decode")]
        async with way.video.source.open() as pictures, way.audio.source.open() as sound:
            shown: list[RawVideo] = await some(pictures, 5)
            heard: list[RawAudio] = await some(sound, 20)
            assert {(each.width, each.height, each.format) for each in shown} == {(320, 180, "i420")}
            # The bars are bright on the left and dark on the right.
            assert shown[-1].data[90, 20] > 150 > 60 > shown[-1].data[90, 300]
            assert [each.sequence for each in shown] == sorted({each.sequence for each in shown})
            assert {each.samples.shape[1] for each in heard} == {2}
            assert 0 < sum(len(each.samples) for each in heard) <= 20 * 480
            await way.application.close()
            async with asyncio.timeout(PATIENCE):
                assert [each async for each in pictures][1:] == []
                assert len([each async for each in sound]) <= 20
        figures = way.video.figures
        assert figures.key_frame_requests >= 1
        assert figures.frames_decoded >= 5
        assert not [each for each in threading.enumerate() if each.name.startswith("decode")]


async def test_unwanted_media_is_not_read() -> None:
    async with uplink("video/VP8") as way:
        await until_frames(way, 2)
        way.video.pass_media(False)
        async with way.video.source.open() as pictures:
            before = way.video.frames
            packets = way.video.figures.packets
            await until(lambda: way.video.figures.packets >= packets + 5)
            assert way.video.frames == before
            way.video.pass_media(True)
            await some(pictures, 2)


async def test_lost_packets_are_retransmitted() -> None:
    async with uplink("video/VP8") as way, way.video.source.open() as pictures:
        await some(pictures, 5)
        way.path.up.change(loss=0.1)
        shown: list[RawVideo] = await some(pictures, 60)
        figures = way.video.figures
        assert figures.packets_lost > 0
        assert figures.nacks > 0
        # Pictures that were only late are all shown, in their order.
        assert [each.sequence for each in shown] == sorted({each.sequence for each in shown})
        assert [each.captured_at for each in shown] == sorted(each.captured_at for each in shown)


async def test_when_nothing_is_sent_again_a_key_frame_is() -> None:
    async with uplink("video/H264") as way, way.video.source.open() as pictures:
        await some(pictures, 5)
        asked = way.video.figures.key_frame_requests
        way.path.down.change(loss=1)
        way.path.up.lose_next(4)
        await until(lambda: way.video.figures.key_frame_requests > asked)
        way.path.down.change(loss=0)
        await some(pictures, 10)


async def test_captured_at_is_on_our_clock() -> None:
    async with uplink("video/VP8") as way, way.video.source.open() as pictures, way.audio.source.open() as sound:
        for frames in (pictures, sound):
            for frame in await some(frames, 10):
                assert 0 <= SystemClock().now() - frame.captured_at < PATIENCE


async def test_receiver_stopped_before_start_leaves_no_task() -> None:
    connection = RTCPeerConnection()
    receiver = RtpReceiver(connection.addTransceiver("video", direction="recvonly"), SystemClock())
    before = asyncio.all_tasks()
    await receiver.stop()
    await receiver.negotiated(Negotiated((), (), {}))
    assert asyncio.all_tasks() == before
    await connection.close()
