"""Many viewers of one avatar: each picture is encoded once, and none of them can harm another."""

import asyncio
import itertools
import signal
from collections.abc import AsyncIterator

import pytest
from openrois_streaming import liveness

from tests.support.black_box import H264, VIDEO, VP8, Application
from tests.support.black_box_media import Picture
from tests.support.demo import Watcher
from tests.support.house import House
from tests.support.house import house as running_house

pytestmark = pytest.mark.media

LONGEST_GAP = 0.7
"""Seconds between two pictures at most, on a machine that does other things as well; a viewer waits 0.033."""


@pytest.fixture
async def house() -> AsyncIterator[House]:
    async with running_house() as built:
        yield built


async def test_three_viewers_share_one_encoder_and_a_fourth_of_another_codec_has_its_own(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    # No viewer is lost here because of silence, however long on a busy machine.
    monkeypatch.setattr(liveness, "SILENCE", float("inf"))
    apps = [await house.guest() for _ in range(3)]
    streams = await asyncio.gather(*(app.play(VIDEO, H264) for app in apps))
    await asyncio.gather(*(app.pictures(stream, 30) for app, stream in zip(apps, streams, strict=True)))
    assert house.avatar.video.running_encoders == 1
    figures = house.figures("video/H264")
    assert (figures.viewers, figures.running) == (3, True)
    numbers = [numbers_seen(app, stream) for app, stream in zip(apps, streams, strict=True)]
    assert len(numbers[0] & numbers[1] & numbers[2]) >= 20, "they see the same pictures"
    assert figures.encoded < 2 * len(numbers[0]), "and each was encoded once"

    fourth = await house.guest()
    fourth.candidates_first = True
    last = await fourth.play(VIDEO, VP8)
    await fourth.pictures(last, 10)
    assert fourth.peer_of(last).codecs() == {"VP8", "rtx"}
    assert house.avatar.video.running_encoders == 2
    assert house.figures("video/H264").viewers == 3
    assert house.figures("video/VP8").viewers == 1

    await apps[0].act("disconnect", streams[0])
    await apps[0].until_status(streams[0], "NOT_CONNECTED")
    await apps[1].drop()
    await apps[2].drop()
    await gone(house, "video/H264", fourth, last)
    assert house.avatar.video.running_encoders == 1, "the orphaned viewer gets no more pictures"
    await fourth.act("disconnect", last)
    await fourth.until_status(last, "NOT_CONNECTED")
    assert house.avatar.video.running_encoders == 0
    assert [house.figures(codec).viewers for codec in ("video/H264", "video/VP8")] == [0, 0]


@pytest.mark.long
@pytest.mark.parametrize(("ending", "silence"), [(signal.SIGKILL, float("inf")), (signal.SIGSTOP, liveness.SILENCE)])
async def test_a_viewer_that_stops_is_gone_and_the_others_never_notice(
    house: House, monkeypatch: pytest.MonkeyPatch, ending: signal.Signals, silence: float
) -> None:
    # One that is killed is gone because its connection breaks: it is noticed although no silence is ever too long. How
    # soon it is depends on what else the machine does, and is not asked.
    monkeypatch.setattr(liveness, "SILENCE", silence)
    staying = await house.guest()
    stream = await staying.play(VIDEO, H264)
    watcher = await asyncio.to_thread(Watcher, house.url, "video/VP8")
    try:
        await asyncio.to_thread(watcher.wait, 5)
        assert house.figures("video/VP8").viewers == 1
        watcher.process.send_signal(ending)
        await gone(house, "video/VP8", staying, stream)
    finally:
        await asyncio.to_thread(watcher.close)
    assert house.avatar.video.running_encoders == 1
    await staying.pictures(stream, 10)
    assert steady(staying.media(stream).pictures)
    assert staying.statuses(stream) == ["NOT_RUNNING", "RUNNING"]


async def gone(house: House, codec: str, witness: Application, stream_id: str) -> None:
    """Wait until there is no viewer of `codec`; checked whenever the witness gets a picture."""
    await witness.pictures(stream_id, 1)
    await witness.news.until(lambda: house.figures(codec).viewers == 0)


def steady(pictures: list[Picture]) -> bool:
    """Whether no picture kept its viewer waiting."""
    return all(b.at - a.at < LONGEST_GAP and a.number < b.number for a, b in itertools.pairwise(pictures))


def numbers_seen(app: Application, stream_id: str) -> set[int]:
    return {picture.number for picture in app.media(stream_id).pictures}
