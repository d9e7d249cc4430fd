"""Every component of the avatar's profile, used from Chromium by the TypeScript SDK, and their results."""

import asyncio
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from playwright.async_api import Browser

from tests.support.browser import Visit, visiting
from tests.support.conversation import aloud, meet
from tests.support.demo import Demo
from tests.support.devices import Devices
from tests.support.hearing import spoken, stereo_48k
from tests.support.people import Sitter, nodding

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "puppet"
PATIENCE: Final = 60_000
"""Milliseconds for each thing that is waited for; an idle machine needs 8 s for all of them."""

_ALL: Final = (Path(__file__).parent / "every_component.js").read_text(encoding="utf-8")
_BY_HAND: Final = {"avatar/teleoperation"}
"""What a script in the page cannot use as a person does."""
_STORY: Final = "Once upon a time there was an avatar that told long stories to all its visitors. " * 6
_ANN: Final = "urn:x-rois:def:person:OpenRoIS::avatar/enrolled/Ann"


@pytest.fixture(scope="module", autouse=True)
def operator(devices: Devices, flite: None, pocketsphinx: None) -> None:
    """A page whose camera shows a nodding person and whose microphone hears a destination, again and again."""
    devices.see(nodding(Sitter("collins"), begin=0.5), 3.0)
    devices.hear(stereo_48k(np.concatenate([spoken("go to the window"), np.zeros(24_000, np.int16)]))[:, 0])


@pytest.mark.timeout(300)
@pytest.mark.long
async def test_every_component_does_what_it_is_for(browser: Browser, avatar: Demo) -> None:
    async with visiting(browser, avatar.page) as visit:
        await meet(visit)
        await visit.status("audio", "RUNNING")
        # An enrolment is a recording.
        await visit.item("consent-recording").check()
        await visit.press("microphone-toggle")
        await visit.press("camera-toggle")
        await visit.until("openrois.microphone.status === 'STREAMING_RUNNING'")
        await visit.until("openrois.camera.status === 'STREAMING_RUNNING'")
        gave = await visit.page.evaluate(f"({_ALL})({PATIENCE})")
        found: dict[str, Any] = gave["found"]
        assert {f"avatar/{name}" for name in found} | _BY_HAND == set(gave["components"])
        _check_streams_and_system(found)
        _check_eyes(found)
        _check_ears(found)
        _check_scene(found)
        _check_acting(found)
        await _drive(visit)


@pytest.mark.long
async def test_reloaded_page_goes_on_with_a_new_session(browser: Browser, avatar: Demo) -> None:
    async with visiting(browser, avatar.page) as visit:
        await meet(visit)
        begun = """async (story) => {
            const { Navigation, SpeechSynthesis } = await import("/openrois.js");
            const { client } = openrois;
            const perform = (Part, name, values) =>
                new Promise((resolve) => new Part(client, `avatar/${name}`).perform(values, resolve).catch(() => {}));
            await perform(SpeechSynthesis, "speech_synthesizer", { speech_text: story });
            await perform(Navigation, "navigation", { target_positions: ["-2.5,2.5", "2.5,0", "-2.5,2.5"] });
        }"""
        await visit.page.evaluate(begun, _STORY)
        await visit.listen()
        await aloud(visit)
        before = await visit.stream_id("video")
        await visit.page.reload()
        await meet(visit)
        assert await visit.stream_id("video") != before
        again = """async () => {
            const { Navigation, SpeechSynthesis } = await import("/openrois.js");
            const speech = new SpeechSynthesis(openrois.client, "avatar/speech_synthesizer");
            const navigation = new Navigation(openrois.client, "avatar/navigation");
            await Promise.all([
                speech.perform({ speech_text: "Here I am." }),
                navigation.perform({ target_positions: ["0,0.5"] }),
            ]);
        }"""
        await visit.page.evaluate(again)
        await visit.plays()
        status = "openrois.client.query('component_status', \"component_ref = 'avatar/navigation'\")"
        assert (await visit.page.evaluate(status))[0]["value"] == "READY"


def _check_streams_and_system(found: dict[str, Any]) -> None:
    assert found["system_info"]["status"] == "READY"
    assert len(found["system_info"]["began"]) == 3
    for name in ("video_streaming", "audio_streaming"):
        assert found[name]["status"] in {"READY", "BUSY"}
        assert found[name]["suspended"] == "STREAMING_SUSPENDED"
    assert "video/H264" in found["video_streaming"]["encodings"]
    assert "audio/opus" in found["audio_streaming"]["encodings"]
    operator = found["operator"]
    assert operator["connected"]
    assert operator["width"] * 9 == operator["height"] * 16
    assert 0.1 < operator["brightness"] < 0.9


def _check_eyes(found: dict[str, Any]) -> None:
    assert found["person_detecter"]["number"] == found["face_detecter"]["number"] == 1
    for name, kind, refs in (("person_localizer", "person", "person_ref"), ("face_localizer", "face", "face_ref")):
        (ref,), (place,) = found[name][refs], found[name]["position_data"]
        assert ref.startswith(f"urn:x-rois:def:{kind}:OpenRoIS::avatar/camera/")
        x, y, _ = map(float, place.split(","))
        assert abs(x) < 0.2
        assert 0.3 < y < 1.5  # a face that fills a fifth of the width
    left, top, width, height = map(float, found["sight"]["box"][0].split(","))
    assert left < 0.5 < left + width
    assert top < 0.45 < top + height
    assert found["enrolment"] == {"person_ref": _ANN, "names": ["Ann"], "left": []}
    assert found["person_identifier"]["person_ref"] == [_ANN]
    visitors = found["visitors"]
    assert visitors["visitor_ref"] == [visitors["attended"]]
    assert (visitors["devices"], visitors["consent"]) == (["microphone camera"], ["live recognition recording"])
    assert found["gesture_recognizer"]["gesture_ref"] == ["urn:x-rois:def:gesture:OMG::1"]


def _check_ears(found: dict[str, Any]) -> None:
    speech = found["speech_recognizer"]
    assert speech["languages"] == ["en"]
    assert speech["recognized_text"][0] == "go to the window"
    assert speech["began"] >= speech["stopped"] >= 1
    assert found["hearing"]["text"] == "go to the window"
    assert found["sound_detecter"][:2] == [1, 0]
    assert "one channel" in str(found["sound_localizer"]["fault"])


def _check_scene(found: dict[str, Any]) -> None:
    assert found["scene_person_detecter"]["number"] == 1
    assert found["scene_person_localizer"]["person_ref"] == ["urn:x-rois:def:person:OpenRoIS::avatar/scene/visitor"]
    assert found["scene_sound_localizer"]["position_data"][0].startswith("1.900,2.250")
    around = found["surroundings"]
    assert len(around["outline"]) == 4
    assert len(around["obstacles"]) >= 4
    assert {"visitor", "radio", "stool"} <= set(around["name"])
    assert around["moved"] > 10


def _check_acting(found: dict[str, Any]) -> None:
    speech = found["speech_synthesizer"]
    # No sound waits to be spoken, and none that was sent without the right to speak was taken.
    assert (found["speech_stream"]["speeches"], found["speech_stream"]["taken"]) == (0, 0)
    assert speech["status"] == found["speech_progress"]["end"] == "OK"
    assert speech["lasted"] > 1000
    assert "en" in speech["languages"]
    assert speech["voices"]
    assert {"Hello", "window"} <= set(found["speech_progress"]["words"])
    assert found["dialogue"] == {"wake_word": ""}
    assert found["reaction"]["status"] == found["gaze"] == "OK"
    assert found["viewpoint"] == ["OK", "OK"]
    assert len(found["reaction"]["reactions"]) == 12
    assert found["move"]["status"] == found["navigation"]["status"] == "OK"
    assert np.allclose(found["move"]["ended"], (0, -0.4, -1.5708), atol=0.05)
    assert np.allclose(found["navigation"]["ended"], (-0.5, 0, 1.5708), atol=0.05)
    assert found["navigation"]["targets"] == [{"target": "-0.5,0,1.5708", "is_final_target": True}]
    assert found["follower"]["status"] == "ABORT"  # it was stopped: OK is not among its ends
    assert abs(found["follower"]["away"] - 0.7) < 0.01


async def _drive(visit: Visit) -> None:
    """Check teleoperation: a pressed key moves the figure, a released one does not."""
    where = "openrois.client.query('robot_position', \"component_ref = 'avatar/system_info'\")"
    operation = "openrois.client.query('operation', \"component_ref = 'avatar/teleoperation'\")"

    async def asked(expression: str) -> dict[str, str]:
        return {each["name"]: each["value"] for each in await visit.page.evaluate(expression)}

    before = (await asked(where))["position_data"]
    await visit.press("control-toggle")
    await visit.until("document.querySelector('[data-testid=control-toggle]').ariaPressed === 'true'")
    await visit.page.keyboard.down("KeyA")
    async with asyncio.timeout(60):
        while (await asked(where))["position_data"] == before:
            pass
    driven = await asked(operation)
    assert (driven["operated"], driven["active"]) == ("true", "true")
    assert float(driven["turn"]) > 0
    await visit.page.keyboard.up("KeyA")
    async with asyncio.timeout(60):
        while (await asked(operation))["active"] == "true":
            pass
    assert float((await asked(operation))["turn"]) == 0
    await visit.page.keyboard.press("Escape")
    await visit.until("document.querySelector('[data-testid=control-toggle]').ariaPressed === 'false'")
