import asyncio
from collections.abc import AsyncIterator
from dataclasses import replace

import pytest
from openrois_avatar.link.encoded_source import MAX_WAITING, EngineEncoded
from openrois_avatar.link.media import Encoded
from openrois_avatar.link.messages import Bitrate, Command, Demand, KeyFrame, LinkError, VideoShape
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_streaming.codecs import H264
from openrois_streaming.publish.video_encoder import VideoEncoder
from openrois_streaming.source.source import EncodedVideo

from tests.support.streaming import VirtualClock, settle
from tests.support.streaming import picture as raw_picture

SHAPE = VideoShape(160, 90, 30, "h264")


@pytest.fixture(scope="module")
def made() -> list[Encoded]:
    """A key frame and pictures that follow it."""
    encoder = VideoEncoder(H264, bitrate=500_000, frame_rate=30)
    chunks = [encoder.encode(raw_picture(number), key_frame=number == 0)[0] for number in range(MAX_WAITING + 4)]
    return [Encoded(number, 0, 160, 90, chunk.keyframe, chunk.data) for number, chunk in enumerate(chunks)]


class Asked:
    """An engine that is asked for things."""

    def __init__(self, *, gone: bool = False) -> None:
        self.commands: list[Command] = []
        self._gone = gone

    def __call__(self, command: Command) -> None:
        if self._gone:
            raise LinkError("the engine is gone")
        self.commands.append(command)


def inlet(asked: Asked) -> EngineEncoded:
    encoded = EngineEncoded(clock := VirtualClock(), PictureDemand(clock))
    encoded.engine_arrived(SHAPE, asked)
    return encoded


async def next_of(pictures: AsyncIterator[EncodedVideo]) -> EncodedVideo:
    async with asyncio.timeout(60):
        return await anext(pictures)


async def test_pictures_flow_in_order_and_all_of_them(made: list[Encoded]) -> None:
    encoded = inlet(Asked())
    async with encoded.open() as pictures:
        for number in range(3):
            encoded.put(made[number])
        seen = [await next_of(pictures) for _ in range(3)]
        assert [picture.keyframe for picture in seen] == [True, False, False]
        assert [picture.sequence - seen[0].sequence for picture in seen] == [0, 1, 2]
        assert (seen[0].data, seen[0].width, seen[0].height) == (made[0].data, 160, 90)
        waiting = asyncio.ensure_future(anext(pictures))
        await settle()
        assert not waiting.done()
        encoded.put(made[3])
        assert (await waiting).sequence == seen[0].sequence + 3


async def test_pictures_that_arrive_while_not_open_are_dropped(made: list[Encoded]) -> None:
    encoded = inlet(Asked())
    encoded.put(made[0])
    async with encoded.open() as pictures:
        encoded.put(made[1])
        assert not (await next_of(pictures)).keyframe
    assert encoded.dropped == 0


async def test_a_reader_that_is_too_slow_loses_all_up_to_the_next_key_frame(made: list[Encoded]) -> None:
    asked = Asked()
    encoded = inlet(asked)
    async with encoded.open() as pictures:
        for picture in made[: MAX_WAITING + 2]:
            encoded.put(picture)
        assert asked.commands == [KeyFrame()]
        assert encoded.dropped == MAX_WAITING + 2
        encoded.put(replace(made[0], sequence=MAX_WAITING + 2))
        assert (await next_of(pictures)).keyframe


async def test_the_engine_is_asked_and_so_is_the_next_one(made: list[Encoded]) -> None:
    first, second, third = Asked(), Asked(), Asked()
    encoded = inlet(first)
    async with encoded.open() as pictures:
        encoded.set_bitrate(300_000)
        encoded.request_key_frame()
        assert first.commands == [Bitrate(300_000), KeyFrame()]
        encoded.put(made[0])
        before = await next_of(pictures)
        encoded.engine_gone()
        encoded.request_key_frame()
        encoded.engine_arrived(SHAPE, second)
        assert second.commands == [Bitrate(300_000), KeyFrame()]
        encoded.put(made[0])
        assert (await next_of(pictures)).sequence > before.sequence + 1
    assert len(first.commands) == 2
    encoded.engine_arrived(SHAPE, third)
    assert third.commands == []


async def test_an_engine_that_does_not_encode_is_asked_nothing() -> None:
    asked = Asked()
    encoded = inlet(asked)
    shapes = [encoded.announced]
    encoded.engine_arrived(None, asked)
    shapes.append(encoded.announced)
    assert shapes == [SHAPE, None]
    async with encoded.open():
        encoded.set_bitrate(1)
    assert asked.commands == []


async def test_an_engine_that_is_just_gone_does_no_harm() -> None:
    encoded = inlet(Asked(gone=True))
    async with encoded.open():
        encoded.request_key_frame()


def test_picture_that_does_not_match_its_header_is_refused(made: list[Encoded]) -> None:
    encoded = inlet(Asked())
    for wrong, named in (
        (
            replace(made[0], data=b"\0\0\1\x42"),
            "VIDEO: a NAL unit of type 2 .*; send H.264 constrained baseline in Annex B form",
        ),
        (replace(made[0], keyframe=False), "the flag of a key frame .*; set it for IDR pictures"),
        (replace(made[1], keyframe=True), "the flag of a key frame"),
        (replace(made[0], width=162), "its SPS says 160x90, not 162x90; send the size of the SPS"),
    ):
        with pytest.raises(LinkError, match=named):
            encoded.put(wrong)


async def test_an_engine_that_sleeps_is_told_first_and_gives_nothing_old(made: list[Encoded]) -> None:
    clock, asked = VirtualClock(now=1000), Asked()
    demand = PictureDemand(clock)
    encoded = EngineEncoded(clock, demand)
    demand.engine_arrived(asked)
    encoded.engine_arrived(SHAPE, asked)
    async with encoded.open() as pictures:
        encoded.request_key_frame()
        assert asked.commands == [Demand(0), Demand(1), KeyFrame()]
        encoded.put(replace(made[0], timestamp_ns=round(999.99e9)))
        encoded.put(replace(made[0], sequence=1, timestamp_ns=round(1000e9)))
        assert (await anext(pictures)).captured_at == 1000.0


async def test_a_key_frame_that_is_too_old_to_be_shown_is_asked_for_anew(made: list[Encoded]) -> None:
    clock, asked = VirtualClock(now=1000), Asked()
    demand = PictureDemand(clock)
    encoded = EngineEncoded(clock, demand)
    demand.engine_arrived(asked)
    encoded.engine_arrived(SHAPE, asked)
    async with encoded.open():
        encoded.request_key_frame()
        asked.commands.clear()
        # Drawn for a moment just before it was asked for: what follows could not be decoded without another one.
        encoded.put(replace(made[0], timestamp_ns=round(999.99e9)))
        assert asked.commands == [KeyFrame()]
        encoded.put(replace(made[1], timestamp_ns=round(999.995e9)))
        encoded.put(replace(made[0], sequence=2, timestamp_ns=round(1000e9)))
        assert asked.commands == [KeyFrame()]
    encoded.put(replace(made[0], sequence=3, timestamp_ns=round(999.999e9)))
    assert asked.commands == [KeyFrame(), Demand(0)]
