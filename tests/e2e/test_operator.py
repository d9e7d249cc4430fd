"""The operator's microphone and camera reach the avatar, and only while the operator has switched them on."""

import json
import re

import pytest
from playwright.async_api import expect

from tests.support.browser import PATIENCE, Visit

pytestmark = [
    pytest.mark.browser,
    pytest.mark.asyncio(loop_scope="session"),
    pytest.mark.usefixtures("devices"),
]

_VISITORS = "openrois.client.query('visitors', \"component_ref = 'avatar/visitors'\")"
_CAMERA = "openrois.client.query('camera', \"component_ref = 'avatar/operator'\")"


async def test_microphone_and_camera_reach_the_avatar_and_are_released(visit: Visit) -> None:
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


async def test_what_may_be_done_is_chosen_before_shown_meanwhile_and_withdrawn_in_one_press(visit: Visit) -> None:
    await visit.plays(1)
    await expect(visit.item("consent-live")).to_be_checked()
    await expect(visit.item("consent-recording")).not_to_be_checked()
    await expect(visit.item("consent-withdraw")).to_be_hidden()
    await visit.item("consent-recognition").uncheck()
    await visit.press("microphone-toggle")
    await visit.until("openrois.microphone.status === 'STREAMING_RUNNING'")
    await expect(visit.item("consent-words")).to_have_text("You may be heard and seen live.")
    told = {each["name"]: each["value"] for each in await visit.page.evaluate(_VISITORS)}
    assert json.loads(told["consent"]) == ["live"]
    await visit.press("consent-withdraw")
    await visit.until("openrois.microphone.status === 'STREAMING_NOT_CONNECTED'")
    await expect(visit.item("consent-withdraw")).to_be_hidden()
    await expect(visit.item("microphone-toggle")).to_be_disabled()


@pytest.mark.long
async def test_avatar_looks_at_the_camera_only_when_allowed_and_remembers_a_face(visit: Visit) -> None:
    await visit.plays(1)
    await visit.press("camera-toggle")
    await expect(visit.item("sending")).to_have_text("Camera is on")
    await visit.until("openrois.camera.status === 'STREAMING_RUNNING'")
    await expect(visit.item("camera-toggle")).to_contain_text("Sent")
    subscribed = [m["params"]["event_type"] for m in visit.sent if m["method"] == "rois.event.subscribe"]
    assert "seen" not in subscribed

    # A face is remembered of who may be recorded.
    await visit.item("consent-recording").check()
    await visit.press("sight-switch")
    await expect(visit.item("camera-toggle")).to_contain_text("Sent, looked at")
    face = visit.item("face")
    await expect(face).to_have_text("A person", timeout=PATIENCE * 1000)
    box, preview = await face.bounding_box(), await visit.item("preview").bounding_box()
    assert box is not None
    assert preview is not None
    # As in a mirror: who is on the left of the picture is on the right.
    assert (box["x"] + box["width"] / 2 - preview["x"]) / preview["width"] == pytest.approx(0.6, abs=0.04)

    await visit.item("enrol-name").fill("Eileen")
    await _enrol(visit)
    await expect(face).to_have_text("Eileen", timeout=PATIENCE * 1000)
    await expect(visit.item("sight-words")).to_have_text("It sees Eileen")
    await visit.page.get_by_role("button", name="Forget Eileen").click()
    await expect(face).to_have_text("A person", timeout=PATIENCE * 1000)

    await visit.press("sight-switch")
    await expect(face).to_have_count(0)
    await expect(visit.item("camera-toggle")).not_to_contain_text("looked at")
    await visit.press("camera-toggle")
    await expect(visit.item("sending")).to_be_hidden()


async def _enrol(visit: Visit) -> None:
    """Enrol the operator's face, again where a busy machine saw it too seldom."""
    words = visit.item("sight-words")
    for _ in range(3):
        await visit.press("enrol")
        await expect(words).to_have_text(re.compile("^It sees Eileen|^No person was enrolled"))
        if "Eileen" in await words.inner_text():
            return
        await expect(words).not_to_contain_text("No person")
