import asyncio
import threading
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest
from openrois_streaming.clock import SystemClock
from openrois_streaming.codecs import VP8
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.receive.playout import SoundPacket
from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.receive.source_audio import AudioSource, LoopAudioSource
from openrois_streaming.receive.source_video import WAITING_LIMIT, EncodedPicture, VideoSource, raw_picture
from openrois_streaming.source.source import RawAudio, RawVideo

from tests.support.streaming import VirtualClock, settle

PATIENCE = 10.0


class Told:
    """A source of pictures, and the calls to its receiver."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.lost = asyncio.Event()
        self._loop = asyncio.get_running_loop()
        self.source = VideoSource(
            lambda: self.calls.append("open"), self._lost, lambda: self.calls.append("close"), raw_picture
        )
        self.source.mime_type = VP8

    def _lost(self) -> None:
        self.calls.append("lost")
        self._loop.call_soon_threadsafe(self.lost.set)


def pictures(count: int) -> list[EncodedPicture]:
    encoder = VideoEncoder(VP8, bitrate=500_000, frame_rate=30)
    made = []
    for number in range(count):
        raw = RawVideo(np.full((72, 64), 60 + number, np.uint8), "i420", 64, 48, number, number / 30)
        (chunk,) = encoder.encode(raw, key_frame=number == 0)
        made.append(EncodedPicture(bytes(chunk.data), number == 0, CaptureTime(100.0 + number, None)))
    return made


async def taken(items: AsyncIterator[Any]) -> Any:
    async with asyncio.timeout(PATIENCE):
        return await anext(items)


async def test_a_reader_hears_of_a_decoder_that_fails_in_an_unknown_way() -> None:
    def fail(timestamp: int, now: float) -> CaptureTime:
        raise RuntimeError("a mistake")

    source = AudioSource(SystemClock(), fail)
    async with source.open() as blocks:
        source.offer(SoundPacket(0, b"\xf8\xff\xfe"), SystemClock().now())
        with pytest.raises(RuntimeError, match="a mistake"):
            await taken(blocks)


class TestVideo:
    async def test_offered_pictures_are_decoded_while_open(self) -> None:
        told = Told()
        first, second, third = pictures(3)
        told.source.offer(first)
        async with told.source.open() as shown:
            for number, each in enumerate((first, second, third)):
                told.source.offer(each)
                picture = await taken(shown)
                assert (picture.sequence, picture.captured_at) == (number, 100.0 + number)
            with pytest.raises(RuntimeError):
                await told.source.open().__aenter__()
        told.source.offer(first)
        assert told.calls == ["open", "close"]
        assert told.source.decoded == 3
        assert not [each for each in threading.enumerate() if each.name == "decode video"]

    async def test_it_begins_with_a_key_frame(self) -> None:
        told = Told()
        first, second, _ = pictures(3)
        async with told.source.open() as shown:
            told.source.offer(second)
            told.source.offer(first)
            assert (await taken(shown)).captured_at == 100.0
        assert told.source.dropped == 1

    async def test_after_an_error_it_goes_on_with_a_key_frame(self) -> None:
        told = Told()
        first, second, _ = pictures(3)
        async with told.source.open() as shown:
            told.source.offer(EncodedPicture(b"\x00nonsense", True, CaptureTime(5.0, None)))
            async with asyncio.timeout(PATIENCE):
                await told.lost.wait()
            told.source.offer(second)
            told.source.offer(first)
            assert (await taken(shown)).captured_at == 100.0
        assert told.calls.count("lost") == 1

    async def test_a_decoder_that_is_too_slow_loses_all_that_waits(self, monkeypatch: pytest.MonkeyPatch) -> None:
        told = Told()
        go_on = threading.Event()
        monkeypatch.setattr(
            "openrois_streaming.receive.source_video.VideoDecoder", lambda mime_type: Slow(go_on, mime_type)
        )
        async with told.source.open():
            for _ in range(WAITING_LIMIT + 3):
                told.source.offer(EncodedPicture(b"x", True, CaptureTime(5.0, None)))
            assert "lost" in told.calls
            assert told.source.dropped > WAITING_LIMIT
            go_on.set()

    async def test_the_end_is_the_end(self) -> None:
        told = Told()
        async with told.source.open() as shown:
            told.source.end_input()
            assert [each async for each in shown] == []
        async with told.source.open() as shown:
            assert [each async for each in shown] == []


class Slow:
    """A decoder that waits until it may go on."""

    def __init__(self, go_on: threading.Event, mime_type: str) -> None:
        self._go_on = go_on

    def decode(self, data: bytes) -> list[Any]:
        self._go_on.wait(PATIENCE)
        return []


def sound(count: int) -> list[SoundPacket]:
    encoder = OpusEncoder(bitrate=64_000)
    raw = RawAudio(np.zeros((960 * count, 1), np.int16), 0.0)
    chunks = encoder.encode(raw, key_frame=False)
    return [SoundPacket(960 * number, bytes(chunk.data)) for number, chunk in enumerate(chunks)]


class TestAudio:
    async def test_offered_sound_is_played_while_open(self) -> None:
        clock = SystemClock()
        source = AudioSource(clock, lambda timestamp, now: CaptureTime(float(timestamp), None))
        packets = sound(3)
        source.offer(packets[0], clock.now())
        assert source.delay == 0.0
        assert source.figures.concealed == 0
        async with source.open() as heard:
            for packet in packets:
                source.offer(packet, clock.now())
            blocks = [await taken(heard) for _ in range(8)]
            # They all come at once: what is too much is left out, for there is nothing to hear.
            assert blocks[0].captured_at <= 960
            assert {each.samples.shape[1] for each in blocks} == {2}
            assert source.delay >= 0
            with pytest.raises(RuntimeError):
                await source.open().__aenter__()
        assert source.decoded >= 8
        assert not [each for each in threading.enumerate() if each.name == "decode audio"]

    async def test_the_end_is_the_end(self) -> None:
        source = AudioSource(SystemClock(), lambda timestamp, now: CaptureTime(now, None))
        async with source.open() as heard:
            source.end_input()
            assert [each async for each in heard] == []
        async with source.open() as heard:
            assert [each async for each in heard] == []


class TestAudioInTheLoop:
    async def test_offered_sound_is_played_while_open(self) -> None:
        clock = SystemClock()
        source = LoopAudioSource(clock, lambda timestamp, now: CaptureTime(float(timestamp), None), 960)
        packets = sound(3)
        source.offer(packets[0], clock.now())
        async with source.open() as heard:
            for packet in packets:
                source.offer(packet, clock.now())
            blocks = [await taken(heard) for _ in range(4)]
            assert blocks[0].captured_at <= 960
            assert all(each.samples.shape[1] == 2 and 0 < len(each.samples) <= 960 for each in blocks)
            assert source.delay >= 0
            with pytest.raises(RuntimeError):
                await source.open().__aenter__()
        assert source.decoded == 4
        assert source.delay == 0.0
        assert not [each for each in threading.enumerate() if each.name == "decode audio"]

    async def test_it_waits_for_the_first_packet_and_ends_with_the_sender(self) -> None:
        source = LoopAudioSource(SystemClock(), lambda timestamp, now: CaptureTime(now, None))
        async with source.open() as heard:
            waiting = asyncio.ensure_future(taken(heard))
            await asyncio.sleep(0)
            assert not waiting.done()
            source.end_input()
            with pytest.raises(StopAsyncIteration):
                await waiting
        async with source.open() as heard:
            assert [each async for each in heard] == []

    async def test_a_loop_that_was_held_up_skips_what_it_missed(self) -> None:
        clock = VirtualClock()
        source = LoopAudioSource(clock, lambda timestamp, now: CaptureTime(now, None), 960)
        async with source.open() as heard:
            for packet in sound(3):
                source.offer(packet, clock.now())
            first = asyncio.ensure_future(anext(heard))
            await clock.advance(0.1)
            await first
            clock.jump(1.0)
            assert (await anext(heard)).captured_at == clock.now()
            following = asyncio.ensure_future(anext(heard))
            await settle()
            assert not following.done(), "it does not play a second of sound at once"
            await clock.advance(0.02)
            await following
