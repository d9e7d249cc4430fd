"""The operator's microphone and camera reach the avatar, and only while the operator wants it."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from tests.support.browser import PATIENCE, Visit, running_browser
from tests.support.people import Sitter, write_y4m

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

_DEVICES = ("--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream")
_CAMERA = "openrois.client.query('camera', \"component_ref = 'avatar/Operator'\")"


@pytest_asyncio.fixture(scope="module", loop_scope="session")
async def browser(chromium: Path, tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Browser]:
    """A browser with a beeping microphone and somebody before its camera, whose user says yes to everything."""
    film = tmp_path_factory.mktemp("camera") / "somebody.y4m"
    write_y4m(film, lambda _: [Sitter("collins", x=0.4)], 0.5)
    async with running_browser(chromium, *_DEVICES, f"--use-file-for-fake-video-capture={film}") as browser:
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


async def test_the_avatar_looks_only_where_it_is_let_and_remembers_a_face_by_its_name(visit: Visit) -> None:
    await visit.plays(1)
    await visit.press("camera-toggle")
    await expect(visit.item("sending")).to_have_text("Camera is on")
    await visit.until("openrois.camera.status === 'STREAMING_RUNNING'")
    await expect(visit.item("camera-toggle")).to_contain_text("Sent")
    subscribed = [m["params"]["event_type"] for m in visit.sent if m["method"] == "rois.event.subscribe"]
    assert "seen" not in subscribed

    await visit.press("sight-switch")
    await expect(visit.item("camera-toggle")).to_contain_text("Sent, looked at")
    face = visit.item("face")
    await expect(face).to_have_text("Somebody", timeout=PATIENCE * 1000)
    box, preview = await face.bounding_box(), await visit.item("preview").bounding_box()
    assert box is not None
    assert preview is not None
    # As in a mirror: who is on the left of the picture is on the right.
    assert (box["x"] + box["width"] / 2 - preview["x"]) / preview["width"] == pytest.approx(0.6, abs=0.04)

    await visit.item("enrol-name").fill("Eileen")
    await visit.press("enrol")
    await expect(face).to_have_text("Eileen", timeout=PATIENCE * 1000)
    await expect(visit.item("sight-words")).to_have_text("It sees Eileen")
    await visit.page.get_by_role("button", name="Forget Eileen").click()
    await expect(face).to_have_text("Somebody", timeout=PATIENCE * 1000)

    await visit.press("sight-switch")
    await expect(face).to_have_count(0)
    await expect(visit.item("camera-toggle")).not_to_contain_text("looked at")
    await visit.press("camera-toggle")
    await expect(visit.item("sending")).to_be_hidden()
