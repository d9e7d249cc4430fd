"""The page of `openrois demo` plays the avatar; its streams are suspended, resumed, disconnected, connected again."""

import itertools
import re

import pytest
from playwright.async_api import expect

from tests.support.browser import Seen, Visit

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

STATUS = "rois.stream.notify_stream_status"
_QUIET = "performance.now() - probe.frames.at(-1).at > 1000"
_SILENT = "performance.now() - probe.markers().at(-1) > 1500"
_SECOND_BY_SECOND = """probe.markers().some((begun, index, all) =>
    [1, 2].every((seconds) => Math.abs(all[index + seconds] - begun - 1000 * seconds) < 200))"""


async def test_the_pictures_count_up_and_no_second_is_lost(visit: Visit) -> None:
    frames = await visit.plays(90)
    # The browser calls back for a picture and may show the next one by then, which is read twice in that case.
    numbers = [number for number, _ in itertools.groupby(frame["number"] for frame in frames)]
    assert len(numbers) >= 60
    assert all(earlier < later for earlier, later in itertools.pairwise(numbers)), numbers
    seconds = (frames[-1]["time"] - frames[0]["time"]) / 1000
    assert 28 < (numbers[-1] - numbers[0]) / seconds < 32
    assert await visit.read("probe.unreadable") == 0
    assert not (await visit.look()).black
    await visit.status("video", "RUNNING")
    await visit.no_banner()


async def test_the_sound_waits_for_its_button_where_a_browser_wants_one(visit: Visit) -> None:
    # What Playwright evaluates in a page counts as an act of its user: until the click, only the wire is looked at.
    await visit.until_told(STATUS, component_ref="avatar/audio_streaming", status="STREAMING_RUNNING")
    await visit.press("sound-on")
    await expect(visit.item("sound-on")).to_be_hidden()
    await expect(visit.item("sound-off")).to_be_visible()
    assert not await visit.read("document.querySelector('[data-testid=avatar-audio]').paused")
    await visit.listen()
    await visit.until("probe.markers().length >= 1")


async def test_the_tone_of_every_second_is_heard(visit: Visit) -> None:
    await visit.listen()
    # Who listens is a script of a page: on a busy machine it hears some of the tones too late.
    await visit.until(_SECOND_BY_SECOND)


@pytest.mark.long
async def test_the_figures_beside_the_picture_are_true(visit: Visit) -> None:
    await visit.plays(45)
    for name, least, most in (("fps", 25, 35), ("latency", 0, 500), ("rtt", 0, 200), ("bitrate", 20e3, 5e6)):
        figure = f"Number(document.querySelector('[data-testid=figure-{name}]').dataset.value)"
        await visit.until(f"{figure} > {least} && {figure} < {most}")
    await expect(visit.item("figure-resolution")).to_have_text(re.compile(r"^640 . 360$"))
    await expect(visit.item("figure-dropped")).to_have_text(re.compile(r"^\d+$"))


async def test_a_suspended_picture_stands_still_and_resumes_without_negotiation(visit: Visit) -> None:
    await visit.plays()
    await visit.status("video", "RUNNING")
    offers, connections = len(visit.told("signaling.offer")), await visit.read("probe.connections.length")
    stream_id = await visit.stream_id("video")

    await visit.press("video-suspend")
    await visit.status("video", "SUSPENDED")
    await visit.until(_QUIET)
    last = await visit.read("probe.frames.at(-1)")
    assert await visit.read("probe.luma()") == pytest.approx(last["luma"], abs=1)
    assert not (await visit.look()).black

    await visit.press("video-resume")
    assert (await visit.plays(1))[-1]["number"] > last["number"]
    await visit.status("video", "RUNNING")
    assert len(visit.told("signaling.offer")) == offers
    assert await visit.read("probe.connections.length") == connections == 1
    assert await visit.stream_id("video") == stream_id


@pytest.mark.long
async def test_suspended_sound_is_silent_and_resumes_without_negotiation(visit: Visit) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    await visit.listen()
    await visit.until("probe.markers().length >= 1")
    offers = len(visit.told("signaling.offer"))

    await visit.press("audio-suspend")
    await visit.status("audio", "SUSPENDED")
    await visit.until(_SILENT)
    await visit.plays()

    heard = len(await visit.read("probe.markers()"))
    await visit.press("audio-resume")
    await visit.until(f"probe.markers().length > {heard}")
    await visit.status("audio", "RUNNING")
    assert len(visit.told("signaling.offer")) == offers


@pytest.mark.long
async def test_a_disconnected_picture_stays_and_connects_again_as_another_stream(visit: Visit) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    stream_id, audio_id = await visit.stream_id("video"), await visit.stream_id("audio")
    seen: list[Seen]
    async with visit.watched() as seen:
        await visit.press("video-disconnect")
        await visit.status("video", "NOT_CONNECTED")
        await visit.until(_QUIET)
        await visit.press("video-connect")
        assert await visit.another_stream("video", stream_id)
        await visit.plays()
        await visit.status("video", "RUNNING")
    assert not any(each.black for each in seen), seen
    await visit.status("audio", "RUNNING")
    assert await visit.stream_id("audio") == audio_id


@pytest.mark.long
async def test_disconnected_sound_leaves_the_picture_alone_and_connects_again(visit: Visit) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    await visit.listen()
    await visit.until("probe.markers().length >= 1")
    stream_id, video_id = await visit.stream_id("audio"), await visit.stream_id("video")

    await visit.press("audio-disconnect")
    await visit.status("audio", "NOT_CONNECTED")
    await visit.until(_SILENT)
    await visit.plays()

    heard = len(await visit.read("probe.markers()"))
    await visit.press("audio-connect")
    assert await visit.another_stream("audio", stream_id)
    await visit.until(f"probe.markers().length > {heard}")
    await visit.status("audio", "RUNNING")
    assert await visit.stream_id("video") == video_id
