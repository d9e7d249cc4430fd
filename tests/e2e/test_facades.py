"""Game engines that do WebRTC themselves: the page plays what comes straight from them."""

from pathlib import Path
from typing import Final

import pytest
from playwright.async_api import Browser

from tests.support.browser import visiting
from tests.support.demo import free_port, running_demo
from tests.support.streamers import FakeStreamer, FakeUnity, FakeUnreal, streaming

pytestmark = [
    pytest.mark.browser,
    pytest.mark.media,
    pytest.mark.timeout(90),
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINES: Final = {"unreal": FakeUnreal, "unity-render-streaming": FakeUnity}


@pytest.mark.parametrize("engine", ENGINES)
async def test_the_page_plays_what_comes_straight_from_a_game_engine(
    browser: Browser, tmp_path: Path, engine: str
) -> None:
    kind: type[FakeStreamer] = ENGINES[engine]
    facade = f"127.0.0.1:{free_port()}"
    with running_demo(tmp_path, engine, "--facade", facade, "--link", f"tcp:127.0.0.1:{free_port()}") as demo:
        async with streaming(kind, f"ws://{facade}/") as played, visiting(browser, demo.page) as visit:
            await visit.plays(30)
            await visit.status("video", "RUNNING")
            await visit.listen()
            await visit.until("probe.markers().length >= 1")
            await visit.page.screenshot(path=tmp_path / f"{engine}.png")

            await visit.press("video-suspend")
            await visit.status("video", "SUSPENDED")
            await visit.until("performance.now() - probe.frames.at(-1).at > 1000")
            assert not (await visit.look()).black
            await visit.press("video-resume")
            await visit.plays(5)
            await visit.status("video", "RUNNING")
            assert len(played.sessions) <= 2
        assert "Traceback" not in demo.log(), demo.log()
