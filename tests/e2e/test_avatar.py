"""The avatar of `openrois demo`: it moves, speaks with its mouth, reacts, looks, and stops."""

import re
from collections import Counter
from pathlib import Path
from typing import Final

import cv2
import pytest
from playwright.async_api import Browser, expect

from tests.support.browser import Visit, visiting
from tests.support.conversation import SAYING, aloud, meet, outcome, say, speak
from tests.support.demo import Demo

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "panda3d"

_PICTURE: Final = (0.0, 0.0, 1.0, 0.94)
_EYES: Final = (0.40, 0.33, 0.25, 0.12)
_ALIVE: Final = 0.3
"""By how much a picture differs from an earlier one, in luma and on average, when the avatar breathes."""
_MOVED: Final = 2.0
"""... when the avatar makes a gesture."""

_VOICE: Final = "avatar/speech_synthesizer"
_STORY: Final = "Once upon a time there was an avatar that told long stories to all its visitors. " * 11
"""Takes longer to tell than anything here may take."""
_IN_TIME: Final = 400
"""Milliseconds between the first sound and the first movement of the mouth; idle machines have 50."""
_ATTEMPTS: Final = 3
"""Sentences of which one has to be in time: a browser on a busy machine shows some pictures late."""


async def test_avatar_moves_while_idle(guest: Visit) -> None:
    await guest.watch("picture", *_PICTURE)
    assert await guest.until(f"probe.watched.picture.filter(({{ away }}) => away > {_ALIVE}).length > 10")
    await guest.no_banner()


async def test_mouth_moves_with_the_sound_of_a_sentence(guest: Visit) -> None:
    speech = await speak(guest, "Hello, I am pleased to meet you. How are you today?")
    await expect(guest.item("say-state")).to_have_text(re.compile(r"^Done after \d+\.\d s$"))
    assert await outcome(guest, _VOICE, "start") == "OK"
    assert speech.noise < 0.001
    assert speech.began < 10_000  # on an idle machine it is 400
    assert 1500 < speech.lasted < 10_000
    assert speech.liveliness > 2
    for _ in range(_ATTEMPTS - 1):
        if abs(speech.mouth_after_sound) >= _IN_TIME:
            speech = await speak(guest, "Hello, I am pleased to meet you. How are you today?")
    assert abs(speech.mouth_after_sound) < _IN_TIME


async def test_speech_stops_in_the_middle_of_a_word(guest: Visit) -> None:
    await guest.listen()
    await say(guest, _STORY)
    await aloud(guest)
    await guest.press("say-stop")
    await guest.until(f"{SAYING} === 'stopped'")
    assert await outcome(guest, _VOICE, "start") == "ABORT"
    await guest.until("probe.sound.slice(-20).every(({ rms }) => rms < 0.001)")


@pytest.mark.long
async def test_speech_is_refused_while_another_visitor_speaks(browser: Browser, avatar: Demo, guest: Visit) -> None:
    async with visiting(browser, avatar.page) as other:
        await meet(other)
        await say(guest, _STORY)
        await guest.until(f"{SAYING} === 'speaking'")
        await say(other, "And now me!")
        await expect(other.item("say-state")).to_have_text(re.compile("^Another visitor is speaking"))
        assert await guest.read(SAYING) == "speaking"
        await guest.press("say-stop")
        await guest.until(f"{SAYING} === 'stopped'")


@pytest.mark.long
async def test_reaction_is_seen_and_ends_by_itself_or_by_the_next_one(guest: Visit) -> None:
    buttons = guest.page.locator("button.reaction")
    await expect(buttons).to_have_count(12)
    for number in range(2):
        await guest.watch("picture", *_PICTURE)
        await buttons.nth(number).click()
        await _performed(guest, number)
        await guest.until(f"probe.watched.picture.some(({{ away }}) => away > {_MOVED})")
    # The next one is pressed at once: on a busy machine the first may be over before a change of the picture is seen.
    await guest.watch("picture", *_PICTURE)
    await buttons.nth(2).click()
    await guest.page.keyboard.press("4")
    await _performed(guest, 3)
    await guest.until(f"probe.watched.picture.some(({{ away }}) => away > {_MOVED})")
    set_and_start = [each["status"] for each in guest.told("rois.command.completed")]
    assert Counter(set_and_start) == {"OK": 4 + 3, "ABORT": 1}


async def _performed(guest: Visit, number: int) -> None:
    """Wait until the page reports the end of a reaction, before that text disappears."""
    name = await guest.page.locator("button.reaction").nth(number).locator("span").inner_text()
    await expect(guest.item("reaction-state")).to_have_text(re.compile(rf"^{name}: done after \d+\.\d s$"))
    assert await outcome(guest, "avatar/reaction", "start") == "OK"


async def test_avatar_looks_where_the_picture_is_clicked(guest: Visit) -> None:
    stage = guest.item("stage")
    box = await stage.bounding_box()
    assert box is not None
    await guest.watch("eyes", *_EYES)
    await stage.click(position={"x": box["width"] * 0.9, "y": box["height"] * 0.5})
    assert await outcome(guest, "avatar/gaze", "look") == "OK"
    assert await guest.until(f"probe.watched.eyes.filter(({{ away }}) => away > {_MOVED}).length > 10")


@pytest.mark.long
async def test_picture_stays_when_the_game_engine_crashes_and_restarts(guest: Visit, avatar: Demo) -> None:
    await guest.status("video", "RUNNING")
    stream_id = await guest.stream_id("video")
    async with guest.watched() as seen:
        avatar.program("openrois_avatar.engines.panda3d").kill()
        await guest.status("video", "NOT_RUNNING")
        await guest.status("video", "RUNNING")
        await guest.plays()
    assert not any(each.black for each in seen), seen
    assert await guest.stream_id("video") == stream_id
    await expect(guest.page.locator("button.reaction").first).to_be_enabled(timeout=15_000)


@pytest.mark.long
async def test_the_page_is_worth_a_picture(guest: Visit, tmp_path: Path) -> None:
    """It waves, and it walks; `make pictures` takes those of the documentation."""
    file = tmp_path / "waving.png"
    await guest.page.get_by_role("button", name="Wave").click()
    await guest.plays(25)
    await guest.page.evaluate("scrollTo(0, 0)")
    await guest.page.screenshot(path=file)

    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (800, 1280, 3)
    assert picture.std() > 20
    assert not (await guest.look()).black

    floor = await guest.item("map").bounding_box()
    assert floor is not None
    for x, y in ((0.3, 0.45), (0.62, 0.2)):
        await guest.page.keyboard.down("Shift")
        await guest.page.mouse.click(floor["x"] + x * floor["width"], floor["y"] + y * floor["height"])
        await guest.page.keyboard.up("Shift")
    await expect(guest.item("map-words")).to_have_text("Walking to 2 places")
    await guest.until("Number(document.querySelector('[data-testid=map]').dataset.figure.split(',')[1]) > 0.7")
    walking = tmp_path / "walking.png"
    await guest.page.screenshot(path=walking)
    assert walking.stat().st_size > 50_000
