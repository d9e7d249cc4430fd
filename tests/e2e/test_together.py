"""Several viewers at once, seen from inside the adapter: one encoder for all of them, and none without a viewer."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack

import pytest
import pytest_asyncio
from openrois_avatar.adapter import Avatar
from playwright.async_api import Browser

from openrois.gateway.server import Gateway
from tests.support.black_box import H264, VIDEO, application
from tests.support.browser import visiting
from tests.support.premises import running_avatar, running_gateway

pytestmark = [pytest.mark.browser, pytest.mark.long, pytest.mark.asyncio(loop_scope="session")]

_GONE_WITHIN = 5.0


@pytest_asyncio.fixture(loop_scope="session")
async def gateway() -> AsyncIterator[Gateway]:
    async with running_gateway() as gateway:
        yield gateway


@pytest_asyncio.fixture(loop_scope="session")
async def avatar(gateway: Gateway) -> AsyncIterator[Avatar]:
    async with running_avatar(gateway) as avatar:
        yield avatar


async def test_two_pages_and_another_application_see_the_work_of_one_encoder(
    browser: Browser, gateway: Gateway, avatar: Avatar
) -> None:
    async with AsyncExitStack() as stack:
        first = await stack.enter_async_context(visiting(browser, gateway.url))
        second = await stack.enter_async_context(visiting(browser, gateway.url))
        app = await stack.enter_async_context(application(gateway.url.replace("http", "ws", 1)))
        stream_id = await app.play(VIDEO, H264)
        _, _, pictures = await asyncio.gather(first.plays(30), second.plays(30), app.pictures(stream_id, 30))
        assert len(pictures) == 30
        for visit in (first, second):
            await visit.status("video", "RUNNING")
            await visit.status("audio", "RUNNING")
        # One for each size that is played: on a busy machine a viewer may have come to the smaller of the two.
        played = [rendition for rendition in avatar.video.made if rendition.figures().viewers]
        assert avatar.video.running_encoders == len(played) < 3
        assert avatar.audio.running_encoders == 1


@pytest.mark.parametrize("run_before_unload", [False, True], ids=["closed", "closed politely"])
async def test_streams_end_when_a_tab_is_closed(
    browser: Browser, gateway: Gateway, avatar: Avatar, run_before_unload: bool
) -> None:
    async with visiting(browser, gateway.url) as visit:
        await visit.plays()
        await visit.status("video", "RUNNING")
        assert avatar.video.running_encoders == avatar.audio.running_encoders == 1
        await visit.page.close(run_before_unload=run_before_unload)
        await _no_encoder_runs(avatar)


async def test_reloaded_page_leaves_no_stream_of_its_former_session(
    browser: Browser, gateway: Gateway, avatar: Avatar
) -> None:
    async with visiting(browser, gateway.url) as visit:
        await visit.plays()
        await visit.page.reload()
        await visit.plays()
        assert avatar.video.running_encoders == 1
    await _no_encoder_runs(avatar)


async def _no_encoder_runs(avatar: Avatar) -> None:
    async with asyncio.timeout(_GONE_WITHIN):
        while avatar.video.running_encoders or avatar.audio.running_encoders:  # noqa: ASYNC110 - nothing announces it
            await asyncio.sleep(0.05)
