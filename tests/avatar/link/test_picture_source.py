import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_source import MAX_AHEAD, EngineVideo, Timestamps, believed
from openrois_streaming.source.source import RawVideo

from tests.support.avatar_link import picture
from tests.support.streaming import VirtualClock, settle


def at(seconds: float) -> int:
    return round(seconds * 1e9)


def test_a_true_timestamp_is_kept() -> None:
    stamps = Timestamps(VirtualClock(now=1000))
    assert stamps.captured_at(at(999.9)) == pytest.approx(999.9)


@pytest.mark.parametrize("claimed", [0, at(998.9), at(1000.1), 2**64 - 1])
def test_a_timestamp_of_another_clock_becomes_the_time_of_arrival(claimed: int) -> None:
    assert Timestamps(VirtualClock(now=1000)).captured_at(claimed) == 1000


def test_sound_may_be_sent_ahead() -> None:
    assert believed(at(1000.4), 1000, MAX_AHEAD) == pytest.approx(1000.4)
    assert believed(at(1000.6), 1000, MAX_AHEAD) == 1000
    assert believed(at(998.9), 1000, MAX_AHEAD) == 1000


def test_time_never_goes_backwards() -> None:
    stamps = Timestamps(VirtualClock(now=1000))
    first, second, third = (stamps.captured_at(at(moment)) for moment in (999.9, 999.8, 999.9))
    assert first < second < third < 999.91


async def next_of(pictures: AsyncIterator[RawVideo]) -> RawVideo:
    async with asyncio.timeout(60):
        return await anext(pictures)


async def test_pictures_flow() -> None:
    video = EngineVideo(clock := VirtualClock(now=1000), PictureDemand(clock))
    async with video.open() as pictures:
        video.put(picture(0, at(999.99)))
        first = await next_of(pictures)
        assert (first.width, first.height, first.format, first.sequence) == (4, 2, "bgra", 0)
        assert first.captured_at == pytest.approx(999.99)
        waiting = asyncio.ensure_future(anext(pictures))
        await settle()
        assert not waiting.done()
        video.put(picture(1))
        assert (await waiting).sequence == 1
    assert (video.received, video.dropped) == (2, 0)


async def test_a_slow_reader_gets_the_newest() -> None:
    video = EngineVideo(clock := VirtualClock(), PictureDemand(clock))
    async with video.open() as pictures:
        for sequence in range(3):
            video.put(picture(sequence))
        assert (await next_of(pictures)).sequence == 2
    assert (video.received, video.dropped) == (3, 2)


async def test_pictures_that_arrive_while_not_open_are_dropped() -> None:
    video = EngineVideo(clock := VirtualClock(), PictureDemand(clock))
    video.put(picture(0))
    async with video.open() as pictures:
        video.put(picture(1))
    assert (video.received, video.dropped) == (2, 0)
    async with video.open() as pictures:
        waiting = asyncio.ensure_future(anext(pictures))
        await settle()
        assert not waiting.done()
        video.put(picture(2))
        assert (await waiting).sequence == 2


async def test_the_next_engine_continues_the_count() -> None:
    video = EngineVideo(clock := VirtualClock(), PictureDemand(clock))
    video.engine_arrived()
    async with video.open() as pictures:
        video.put(picture(7))
        assert (await next_of(pictures)).sequence == 7
        video.engine_arrived()
        video.put(picture(0))
        assert (await next_of(pictures)).sequence == 8


async def test_lent_pixels_are_copied_when_they_are_read_and_torn_ones_not_shown() -> None:
    video = EngineVideo(clock := VirtualClock(), PictureDemand(clock))
    pixels = bytearray(32)
    async with video.open() as pictures:
        video.put(replace(picture(0), pixels=memoryview(pixels)), lambda: False)
        waiting = asyncio.ensure_future(next_of(pictures))
        await settle()
        assert not waiting.done()
        video.count_lost()
        pixels[:] = bytes([7] * 32)
        video.put(replace(picture(2), pixels=memoryview(pixels)), lambda: True)
        shown = await waiting
        pixels[:] = bytes(32)
    assert (shown.sequence, set(shown.data.flat)) == (2, {7})
    assert (video.received, video.dropped) == (3, 2)
