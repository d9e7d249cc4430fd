"""The operator's microphone and camera reach the avatar, and only while the operator wants it."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser

from tests.support.browser import Visit, running_browser

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

_DEVICES = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
_CAMERA = "openrois.client.query('camera', \"component_ref = 'avatar/Operator'\")"


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def browser(chromium: Path) -> AsyncIterator[Browser]:
    """A browser with a beeping microphone and a camera that shows something, whose user says yes to everything."""
    async with running_browser(chromium, *_DEVICES) as browser:
        yield browser


async def test_microphone_and_camera_reach_the_avatar_and_are_let_go(visit: Visit) -> None:
    await visit.plays(1)
    await visit.press("microphone-toggle")
    await visit.press("camera-toggle")
    await visit.until("openrois.microphone.status === 'STREAMING_RUNNING'")
    await visit.until("openrois.camera.status === 'STREAMING_RUNNING'")
    level = "document.querySelector('[data-testid=level-{}]').dataset.value > -60"
    await visit.until(level.format("here"))
    await visit.until(level.format("there"))
    seen = {each["name"]: float(each["value"]) for each in await visit.page.evaluate(_CAMERA)}
    assert (seen["width"], seen["height"]) == (640, 360)
    await visit.until("document.querySelector('[data-testid=preview]').readyState >= 2")

    tracks = await visit.page.evaluate_handle("[openrois.microphone.captured, openrois.camera.captured]")
    await visit.press("microphone-toggle")
    await visit.press("camera-toggle")
    assert await tracks.evaluate("all => all.every(({ readyState }) => readyState === 'ended')")
    await visit.until("openrois.microphone.status === 'STREAMING_NOT_CONNECTED'")
    await visit.plays()
    await visit.status("video", "RUNNING")
