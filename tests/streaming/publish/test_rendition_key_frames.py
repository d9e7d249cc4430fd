"""Key frames of a rendition: for viewers that join, resume or lose data, and in the mailbox of each."""

import asyncio
from contextlib import AsyncExitStack

import pytest
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameCause
from openrois_streaming.publish.rendition import KeyFrameMailbox
from openrois_streaming.source.fanout import DropOldest

from tests.support.rendition_stage import FRAME, Stage, got
from tests.support.streaming import picture, settle


async def test_a_viewer_that_joins_gets_a_key_frame_first_and_nothing_before_it(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        for _ in range(5):
            await stage.shoot(first)
        async with stage.rendition.subscribe() as second:
            assert (await stage.shoot(first)).keyframe
            joined = await got(second)
            assert (joined.keyframe, joined.sequence) == (True, 5)
            assert not (await stage.shoot(first)).keyframe
            assert (await got(second)).sequence == 6
            assert second.dropped == 0


async def test_a_viewer_that_joins_gets_the_last_picture_at_once_if_it_is_fresh() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        for _ in range(5):
            await stage.shoot(first)
        await stage.clock.advance(0.05)
        async with stage.rendition.subscribe() as second:
            again = await got(second)
            assert (again.keyframe, again.data, again.sequence) == (True, b"4", 5)
            assert await got(first) == again
            assert not (await stage.shoot(first)).keyframe
            assert (await got(second)).data == b"5"
        assert (stage.rendition.figures().starts, stage.rendition.figures().dropped_input) == (2, 0)


async def test_a_picture_from_before_a_pause_is_never_shown_again() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(0.07)
        async with stage.rendition.subscribe() as second:
            assert (await stage.shoot(first)).keyframe
            assert (await got(second)).data == b"1"
    await stage.clock.advance(0.01)
    async with stage.rendition.subscribe() as third:
        await stage.shoot(third)
        assert stage.encoders.made[-1].encoded == [2], "nothing is kept without a viewer"


@pytest.mark.parametrize("turns", range(12))
async def test_a_viewer_that_resumes_while_the_encoder_stops_gets_a_key_frame(turns: int) -> None:
    """Whatever turn of the loop it comes in: the encoder that still stops may be the one that is asked."""
    stage = Stage(fresh=0.06)
    async with AsyncExitStack() as suspended:
        viewer = await suspended.enter_async_context(stage.rendition.subscribe())
        for _ in range(5):
            await stage.shoot(viewer)
        leaving = asyncio.create_task(suspended.aclose())
        for _ in range(turns):
            await asyncio.sleep(0)
        async with stage.rendition.subscribe() as resumed:
            await leaving
            await settle()
            for number in range(5, 10):
                await stage.clock.advance(FRAME)
                await stage.source.feed(picture(number, stage.clock.now()))
            assert (await got(resumed)).keyframe


async def test_repairs_from_the_last_picture_keep_to_their_budget() -> None:
    stage = Stage(fresh=0.06)
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(0.01)
        for _ in range(20):
            stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        assert (await got(first)).keyframe
        for _ in range(3):
            assert not (await stage.shoot(first)).keyframe
            stage.rendition.request_key_frame(KeyFrameCause.REPAIR)
        assert stage.rendition.figures().repairs == 1


async def test_viewers_that_join_within_100_ms_share_a_key_frame(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        async with stage.rendition.subscribe() as second, stage.rendition.subscribe() as third:
            keys = [(await stage.shoot(first)).keyframe for _ in range(6)]
            assert keys == [False, False, False, True, False, False]
            assert (await got(second)).sequence == (await got(third)).sequence == 4
    assert stage.rendition.figures().starts == 2


async def test_a_key_frame_under_way_serves_the_viewer_that_joins_meanwhile(stage: Stage) -> None:
    async with stage.rendition.subscribe() as first:
        await stage.shoot(first)
        await stage.clock.advance(1)
        encoder = stage.encoders.made[0]
        async with stage.rendition.subscribe() as second:
            encoder.go_on.clear()
            await stage.source.feed(picture(1, stage.clock.now()))
            async with stage.rendition.subscribe() as third:
                encoder.go_on.set()
                assert [(await got(viewer)).keyframe for viewer in (first, second, third)] == [True] * 3
                await stage.clock.advance(1)
                assert not (await stage.shoot(first)).keyframe


async def test_repairs_are_limited_and_do_not_delay_starts(stage: Stage) -> None:
    rendition = stage.rendition
    async with rendition.subscribe() as first:
        await stage.shoot(first)
        repairs = []
        for number in range(1, 61):
            rendition.request_key_frame(KeyFrameCause.REPAIR)
            if (await stage.shoot(first)).keyframe:
                repairs.append(number)
        assert repairs == [1, 35]
        async with rendition.subscribe():
            rendition.request_key_frame(KeyFrameCause.REPAIR)
            assert (await stage.shoot(first)).keyframe
        figures = rendition.figures()
        assert (figures.key_frames, figures.starts, figures.repairs) == (4, 2, 2)


async def test_stalled_viewer_resumes_at_a_key_frame_without_harm_to_others(stage: Stage) -> None:
    async with stage.rendition.subscribe() as fast, stage.rendition.subscribe(maxsize=4) as stalled:
        keys = [(await stage.shoot(fast)).keyframe for _ in range(60)]
        assert keys == [True] + [False] * 59, "without a reader no key frame is spent"
        assert stalled.dropped == 60
        back = asyncio.create_task(got(stalled))
        await settle()
        assert (await stage.shoot(fast)).keyframe
        assert (await back).sequence == 60
        assert not (await stage.shoot(fast)).keyframe
        assert (await got(stalled)).sequence == 61
        assert (fast.dropped, fast.delivered) == (0, 62)
    figures = stage.rendition.figures()
    assert (figures.starts, figures.repairs) == (1, 1)


def frame(sequence: int, *, keyframe: bool = False) -> EncodedFrame:
    return EncodedFrame(b"", (), sequence, 90_000, keyframe, sequence, 0.0)


def test_the_mailbox_of_a_viewer_counts_what_it_loses_and_asks_when_it_is_read_again() -> None:
    asked = []
    mailbox = KeyFrameMailbox(3, lambda: asked.append(1))
    mailbox.awaited()
    assert [mailbox.put(frame(0)), len(mailbox)] == [0, 0]
    assert [mailbox.put(frame(number, keyframe=number == 1)) for number in range(1, 4)] == [0, 0, 0]
    assert [mailbox.put(frame(4)), len(mailbox)] == [4, 0]
    assert [mailbox.put(frame(5)), len(mailbox), asked] == [1, 0, []]
    mailbox.awaited()
    assert asked == [1]
    assert mailbox.put(frame(6, keyframe=True)) == 0
    assert mailbox.pop().sequence == 6
    mailbox.awaited()
    assert asked == [1]


def test_a_key_frame_takes_the_place_of_a_full_mailbox_and_joins_another() -> None:
    mailbox = KeyFrameMailbox(2, lambda: pytest.fail("nothing is broken"))
    mailbox.put(frame(0, keyframe=True))
    assert mailbox.put(frame(1, keyframe=True)) == 0
    assert [mailbox.put(frame(2, keyframe=True)), len(mailbox)] == [2, 1]
    assert mailbox.put(frame(3)) == 0
    assert [mailbox.pop().sequence, mailbox.pop().sequence] == [2, 3]


def test_a_mailbox_of_pictures_holds_at_least_one() -> None:
    with pytest.raises(ValueError, match="maxsize must be 1 or more, not 0"):
        KeyFrameMailbox(0, lambda: None)
    assert len(DropOldest[int](1)) == 0
