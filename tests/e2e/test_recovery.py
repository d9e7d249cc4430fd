"""Recovery: the page names what is lost, keeps its last picture, and goes on by itself."""

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from tests.support.browser import GATEWAY_AWAY, Visit, visiting
from tests.support.demo import Demo

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]


@pytest_asyncio.fixture(loop_scope="session")
async def visit(browser: Browser, demo: Demo) -> AsyncIterator[Visit]:
    async with visiting(browser, demo.page, tolerated=[GATEWAY_AWAY]) as visit:
        yield visit


async def test_a_killed_adapter_is_named_and_its_picture_lasts_until_the_next_one_plays(
    visit: Visit, demo: Demo
) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    video, audio = await visit.stream_id("video"), await visit.stream_id("audio")
    await visit.listen()
    async with visit.watched() as seen:
        demo.program("avatar").kill()
        await visit.banner("adapter-gone", "has left")
        await visit.another_stream("video", than=video)
        await visit.another_stream("audio", than=audio)
        await visit.plays()
        await visit.no_banner()
    await visit.status("video", "RUNNING")
    await visit.status("audio", "RUNNING")
    heard = len(await visit.read("probe.markers()"))
    await visit.until(f"probe.markers().length > {heard}")
    assert not any(each.black for each in seen), seen


async def test_a_killed_gateway_is_named_and_found_again(visit: Visit, demo: Demo) -> None:
    await visit.plays()
    video = await visit.stream_id("video")
    async with visit.watched() as seen:
        demo.program("gateway").kill()
        words = await visit.banner("no-gateway", "The gateway does not answer")
        gone = await visit.read("performance.now()")
        assert "Trying again in" in words or "Trying now" in words
        await visit.another_stream("video", than=video)
        away = await visit.read("performance.now()") - gone
        await visit.plays()
        await visit.no_banner()
    await visit.status("video", "RUNNING")
    await visit.status("audio", "RUNNING")
    assert not any(each.black for each in seen), seen
    # The media does not need the gateway: the old stream plays until the new one does.
    assert await visit.longest_gap() < max(1500, away / 2)


@pytest.mark.long
async def test_a_suspended_picture_comes_back_suspended(visit: Visit, demo: Demo) -> None:
    await visit.plays()
    await visit.status("video", "RUNNING")
    await visit.press("video-suspend")
    await visit.status("video", "SUSPENDED")
    video = await visit.stream_id("video")
    async with visit.watched() as seen:
        demo.program("avatar").kill()
        await visit.another_stream("video", than=video)
        await visit.status("video", "SUSPENDED")
        await visit.press("video-resume")
        await visit.plays()
    await visit.status("video", "RUNNING")
    assert not any(each.black for each in seen), seen


async def test_media_path_is_replaced_under_a_running_picture(visit: Visit) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    video, audio = await visit.stream_id("video"), await visit.stream_id("audio")
    (first,) = {offer["peer_id"] for offer in visit.told("signaling.offer")}
    async with visit.watched() as seen:
        await visit.page.evaluate(f"openrois.client.call('signaling.restart', {{ peer_id: '{first}' }})")
        await visit.until_told("signaling.offer", replaces=first)
        await visit.until("probe.connections[0].connectionState === 'closed'")
        await visit.plays()
    assert await visit.stream_id("video") == video
    assert await visit.stream_id("audio") == audio
    assert await visit.read("probe.connections.length") == 2
    assert await visit.longest_gap() < 1500
    assert not any(each.black for each in seen), seen
    await visit.status("video", "RUNNING")
    await visit.status("audio", "RUNNING")


@pytest.mark.long
async def test_reloaded_page_restores_its_state(visit: Visit) -> None:
    await visit.plays()
    await visit.status("audio", "RUNNING")
    await visit.press("audio-suspend")
    await visit.status("audio", "SUSPENDED")
    video = await visit.stream_id("video")
    await visit.page.reload()
    assert not (await visit.look()).black
    await visit.another_stream("video", than=video)
    await visit.plays()
    assert not (await visit.look()).black
    await visit.status("video", "RUNNING")
    await visit.status("audio", "SUSPENDED")


@pytest.mark.long
async def test_the_statistics_of_the_last_minute_are_drawn_over_the_picture(visit: Visit) -> None:
    await visit.plays()
    await expect(visit.item("statistics")).to_be_hidden()
    await visit.press("statistics-toggle")
    await visit.until("document.querySelector('[data-testid=plot-rate]').dataset.value > 20")
    await expect(visit.item("plot-resolution")).to_contain_text("640")
    await visit.page.keyboard.press("g")
    await expect(visit.item("statistics")).to_be_hidden()
