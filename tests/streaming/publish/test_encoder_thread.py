import asyncio
import threading

import pytest
from openrois_streaming.publish.encoder_thread import EncoderThread
from openrois_streaming.source.source import RawVideo

from tests.support.streaming import FakeEncoder, FakeEncoders, picture, settle


@pytest.fixture
def encoders() -> FakeEncoders:
    return FakeEncoders()


def thread_of(encoders: FakeEncoders, depth: int = 1, join_timeout: float = 2.0) -> EncoderThread[RawVideo]:
    return EncoderThread(lambda: encoders(1000), depth=depth, name="encoder under test", join_timeout=join_timeout)


async def made(encoders: FakeEncoders, thread: EncoderThread[RawVideo]) -> FakeEncoder:
    """The encoder, once it has encoded its first frame."""
    thread.offer(picture(0))
    assert await taken(thread) == b"0"
    return encoders.made[0]


async def taken(thread: EncoderThread[RawVideo]) -> bytes | None:
    async with asyncio.timeout(60):
        chunk = await thread.get()
    return chunk.data if chunk else None


def hold(encoder: FakeEncoder, thread: EncoderThread[RawVideo], sequence: int) -> None:
    """Let the encoder be busy with frame `sequence` until the test lets it go on."""
    while encoder.entered.acquire(blocking=False):
        pass
    encoder.go_on.clear()
    thread.offer(picture(sequence))
    assert encoder.entered.acquire(timeout=5)


async def test_encoder_runs_in_one_thread_that_ends(encoders: FakeEncoders) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        thread.offer(picture(1), key_frame=True)
        assert await taken(thread) == b"1"
        assert encoder.forced == [1]
        assert encoder.thread.name == thread.name == "encoder under test"
        assert encoder.thread is not threading.current_thread()
        assert encoder.thread.is_alive()
        assert thread.encode_seconds > 0
    assert not encoder.thread.is_alive()
    assert len(encoders.made) == 1


async def test_a_busy_encoder_gets_the_latest_frame_and_the_key_frame_asked_of_a_lost_one(
    encoders: FakeEncoders,
) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.offer(picture(2), key_frame=True)
        thread.offer(picture(3))
        thread.offer(picture(4))
        assert thread.dropped == 2
        encoder.go_on.set()
        assert [await taken(thread), await taken(thread)] == [b"1", b"4"]
        assert encoder.forced == [4]


async def test_hasten_takes_the_newest_waiting_frame_or_repeats_the_last(
    encoders: FakeEncoders,
) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.offer(picture(2))
        thread.hasten(picture(1))
        encoder.go_on.set()
        assert [await taken(thread), await taken(thread)] == [b"1", b"2"]
        assert encoder.forced == [2]
        hold(encoder, thread, 3)
        thread.hasten(picture(3))
        thread.offer(picture(4))
        encoder.go_on.set()
        assert [await taken(thread), await taken(thread)] == [b"3", b"4"]
        assert (encoder.forced, thread.dropped) == ([2, 4], 0)
        thread.hasten(picture(4))
        assert await taken(thread) == b"4"
        assert (encoder.forced, thread.dropped) == ([2, 4, 4], 0)


async def test_a_deeper_hand_over_keeps_what_waits_in_order(encoders: FakeEncoders) -> None:
    async with thread_of(encoders, depth=3) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        for sequence in (2, 3, 4, 5):
            thread.offer(picture(sequence))
        encoder.go_on.set()
        assert [await taken(thread) for _ in range(4)] == [b"1", b"3", b"4", b"5"]
        assert thread.dropped == 1


async def test_a_failure_comes_after_the_chunks_before_it(encoders: FakeEncoders) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        encoder.go_on.set()
        assert await taken(thread) == b"1"
        encoder.failure = OSError("no memory")
        thread.offer(picture(2))
        with pytest.raises(OSError, match="no memory"):
            await taken(thread)


async def test_an_encoder_that_cannot_be_made_is_a_failure(encoders: FakeEncoders) -> None:
    encoders.failure = OSError("no such codec")
    async with thread_of(encoders) as thread:
        with pytest.raises(OSError, match="no such codec"):
            await taken(thread)


async def test_the_end_of_the_input_lets_out_what_went_in(encoders: FakeEncoders) -> None:
    async with thread_of(encoders, depth=2) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.offer(picture(2))
        thread.end_input(None)
        encoder.go_on.set()
        assert [await taken(thread), await taken(thread), await taken(thread)] == [b"1", b"2", None]


async def test_the_failure_of_the_input_comes_last(encoders: FakeEncoders) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.end_input(ConnectionError("the camera is gone"))
        encoder.go_on.set()
        assert await taken(thread) == b"1"
        with pytest.raises(ConnectionError):
            await taken(thread)


async def test_a_new_bit_rate_is_set_before_the_next_frame(encoders: FakeEncoders) -> None:
    async with thread_of(encoders) as thread:
        encoder = await made(encoders, thread)
        thread.set_bitrate(500)
        thread.set_bitrate(700)
        thread.offer(picture(1))
        await taken(thread)
        thread.offer(picture(2))
        await taken(thread)
        assert encoder.bitrates == [700]


async def test_thread_rests_while_chunks_are_not_fetched(encoders: FakeEncoders) -> None:
    async with thread_of(encoders, depth=4) as thread:
        encoder = await made(encoders, thread)
        while encoder.entered.acquire(blocking=False):
            pass
        for sequence in range(1, 9):
            thread.offer(picture(sequence))
            assert encoder.entered.acquire(timeout=5)
        for sequence in range(9, 19):
            thread.offer(picture(sequence))
        assert thread.dropped == 6
        assert [await taken(thread) for _ in range(12)] == [b"%d" % n for n in (*range(1, 9), *range(15, 19))]


async def test_waiting_frames_are_dropped_on_closing(encoders: FakeEncoders) -> None:
    async with thread_of(encoders, depth=4) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.offer(picture(2))
        closing = asyncio.create_task(thread.__aexit__(None, None, None))
        await settle()
        encoder.go_on.set()
        await closing
        assert encoder.encoded == [0, 1]


async def test_an_encoder_that_does_not_return_is_left_behind(
    encoders: FakeEncoders, caplog: pytest.LogCaptureFixture
) -> None:
    async with thread_of(encoders, join_timeout=0) as thread:
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
    assert "does not return" in caplog.text
    encoder.go_on.set()
    encoder.thread.join(5)
    assert not encoder.thread.is_alive()


def test_a_loop_that_is_gone_does_not_trouble_the_thread(encoders: FakeEncoders) -> None:
    async def abandon() -> FakeEncoder:
        thread = await thread_of(encoders).__aenter__()
        encoder = await made(encoders, thread)
        hold(encoder, thread, 1)
        thread.end_input(None)
        return encoder

    encoder = asyncio.run(abandon())
    encoder.go_on.set()
    encoder.thread.join(5)
    assert not encoder.thread.is_alive()
    assert encoder.encoded == [0, 1]
