"""Whatever dies, the page says so, keeps its last picture, and goes on by itself when it is back."""

from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser

from tests.support.browser import GATEWAY_AWAY, Visit, visiting
from tests.support.demo import Demo

pytestmark = [pytest.mark.browser, pytest.mark.timeout(60), pytest.mark.asyncio(loop_scope="session")]


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
    async with visit.watched() as seen:
        demo.program("avatar").kill()
        await visit.banner("adapter-gone", "avatar has left")
        await visit.another_stream("video", than=video)
        await visit.another_stream("audio", than=audio)
        await visit.plays()
        await visit.no_banner()
    await visit.status("video", "RUNNING")
    await visit.status("audio", "RUNNING")
    assert len(seen) > 3
    assert not any(each.black for each in seen), seen


async def test_a_killed_gateway_is_named_and_found_again(visit: Visit, demo: Demo) -> None:
    await visit.plays()
    video = await visit.stream_id("video")
    async with visit.watched() as seen:
        demo.program("gateway").kill()
        words = await visit.banner("no-gateway", "The gateway does not answer")
        assert "Trying again in" in words
        await visit.another_stream("video", than=video)
        await visit.plays()
        await visit.no_banner()
    await visit.status("video", "RUNNING")
    await visit.status("audio", "RUNNING")
    assert not any(each.black for each in seen), seen


async def test_a_page_that_is_loaded_again_plays_again(visit: Visit) -> None:
    await visit.plays()
    video = await visit.stream_id("video")
    await visit.page.reload()
    await visit.another_stream("video", than=video)
    await visit.plays()
    await visit.status("video", "RUNNING")
