"""The avatar of `openrois demo` lives: it moves, speaks with its mouth, reacts, looks, and stops when it is told to."""

import os
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
"""By how much a picture differs from an earlier one, in luma and on average, when somebody breathes in it."""
_MOVED: Final = 2.0
"""... when somebody makes a gesture in it."""

_DOCS: Final = Path(__file__).parents[2] / "docs"
_VOICE: Final = "avatar/speech_synthesizer"
_STORY: Final = "Once upon a time there was an avatar that told long stories to whoever would listen. " * 11
"""Takes longer to tell than anything here may take."""
_IN_TIME: Final = 400
"""Milliseconds between the first sound and the first movement of the mouth; idle machines have 50."""


async def test_it_is_alive_without_being_asked(guest: Visit) -> None:
    await guest.watch("picture", *_PICTURE)
    assert await guest.until(f"probe.watched.picture.filter(({{ away }}) => away > {_ALIVE}).length > 10")
    await guest.no_banner()


async def test_it_speaks_a_sentence_and_its_mouth_moves_with_the_sound(guest: Visit) -> None:
    speech = await speak(guest, "Hello, I am pleased to meet you. How are you today?")
    await expect(guest.item("say-state")).to_have_text(re.compile(r"^Done after \d+\.\d s$"))
    assert await outcome(guest, _VOICE, "start") == "OK"
    assert speech.noise < 0.001
    assert speech.began < 10_000  # on an idle machine it is 400
    assert 1500 < speech.lasted < 10_000
    assert speech.liveliness > 2
    assert abs(speech.mouth_after_sound) < _IN_TIME


async def test_it_stops_in_the_middle_of_a_word(guest: Visit) -> None:
    await guest.listen()
    await say(guest, _STORY)
    await aloud(guest)
    await guest.press("say-stop")
    await guest.until(f"{SAYING} === 'stopped'")
    assert await outcome(guest, _VOICE, "start") == "ABORT"
    await guest.until("probe.sound.slice(-20).every(({ rms }) => rms < 0.001)")


@pytest.mark.long
async def test_two_people_cannot_speak_through_it_at_once(browser: Browser, avatar: Demo, guest: Visit) -> None:
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
async def test_a_reaction_is_seen_and_ends_by_itself_or_by_the_next_one(guest: Visit) -> None:
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
    """Wait until the page says that it has ended; the words go away after some seconds, what was watched does not."""
    name = await guest.page.locator("button.reaction").nth(number).locator("span").inner_text()
    await expect(guest.item("reaction-state")).to_have_text(re.compile(rf"^{name}: done after \d+\.\d s$"))
    assert await outcome(guest, "avatar/reaction", "start") == "OK"


async def test_it_looks_where_the_picture_is_clicked(guest: Visit) -> None:
    stage = guest.item("stage")
    box = await stage.bounding_box()
    assert box is not None
    await guest.watch("eyes", *_EYES)
    await stage.click(position={"x": box["width"] * 0.9, "y": box["height"] * 0.5})
    assert await outcome(guest, "avatar/gaze", "look") == "OK"
    assert await guest.until(f"probe.watched.eyes.filter(({{ away }}) => away > {_MOVED}).length > 10")


@pytest.mark.long
async def test_a_crashed_game_engine_leaves_its_picture_and_comes_back(guest: Visit, avatar: Demo) -> None:
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
    """`OPENROIS_WRITE_SCREENSHOTS=1` makes the pictures of the README and the docs: it waves, and it walks."""
    write = os.environ.get("OPENROIS_WRITE_SCREENSHOTS") == "1"
    file = (_DOCS if write else tmp_path) / "demo.png"
    if write:
        await say(guest, "Hello! I am an avatar, live in your browser.")
        await guest.until(f"{SAYING} === 'done'")
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
    walking = (_DOCS if write else tmp_path) / "map.png"
    await guest.page.screenshot(path=walking)
    assert walking.stat().st_size > 50_000
