"""A game engine that does WebRTC itself: the page plays its stream."""

from pathlib import Path

import pytest
from playwright.async_api import Browser

from tests.support.browser import visiting
from tests.support.streamers import FakeUnreal, house, streaming

pytestmark = [
    pytest.mark.browser,
    pytest.mark.media,
    pytest.mark.timeout(60),
    pytest.mark.asyncio(loop_scope="session"),
]


@pytest.mark.long
async def test_page_plays_the_stream_of_a_game_engine(browser: Browser, tmp_path: Path) -> None:
    async with (
        house("unreal") as here,
        streaming(FakeUnreal, here.avatar.url) as played,
        visiting(browser, here.gateway.url) as visit,
    ):
        await visit.plays(30)
        await visit.status("video", "RUNNING")
        await visit.listen()
        await visit.until("probe.markers().length >= 1")
        await visit.page.screenshot(path=tmp_path / "unreal.png")

        await visit.press("video-suspend")
        await visit.status("video", "SUSPENDED")
        await visit.until("performance.now() - probe.frames.at(-1).at > 1000")
        assert not (await visit.look()).black
        await visit.press("video-resume")
        await visit.plays(5)
        await visit.status("video", "RUNNING")

        # The engine crashes and comes back: so does the picture.
        await played.crash()
        await visit.status("video", "NOT_CONNECTED")
        async with streaming(FakeUnreal, here.avatar.url):
            await visit.plays(5)
            await visit.status("video", "RUNNING")
