"""The floor map of the page: a click or the keyboard sends the avatar there, and it arrives; a person is followed."""

import math
import re
from contextlib import suppress
from typing import Final

import pytest
from playwright.async_api import Browser, expect

from tests.support.browser import PATIENCE, Visit, visiting
from tests.support.conversation import all_stopped, outcome
from tests.support.demo import Demo

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "puppet"

_FIGURE: Final = "document.querySelector('[data-testid=map]').dataset.figure"
_NO_STOP: Final = """() => {
    const { control } = openrois.client;
    control.stopAll = () => {
        delete control.stopAll;
        return Promise.reject(new Error("an arm: no answer"));
    };
}"""
"""Lets the next STOP fail."""
_VISITOR: Final = """(() => {
    const { left, top, width, height } =
        document.querySelector(".map-thing.person circle").getBoundingClientRect();
    return [left + width / 2, top + height / 2];
})()"""


async def _figure(visit: Visit) -> tuple[float, float]:
    """Return where the map shows the figure."""
    x, y = str(await visit.until(_FIGURE)).split(",")
    return float(x), float(y)


async def _click(visit: Visit, x: float, y: float) -> None:
    """Click on a place of the room, which is 6 m wide and 5 m deep, with 0.2 m around it."""
    box = await visit.item("map").bounding_box()
    assert box is not None
    metre = box["width"] / 6.4
    await visit.page.mouse.click(box["x"] + (x + 3.2) * metre, box["y"] + (4.2 - y) * metre)


async def _says(visit: Visit, words: str) -> None:
    await expect(visit.item("map-words")).to_have_text(re.compile(words), timeout=PATIENCE * 1000)


async def test_a_click_sends_the_avatar_there_and_it_arrives(guest: Visit) -> None:
    await _figure(guest)
    await _says(guest, "^Click where")
    await _click(guest, -0.8, 0.6)
    await _says(guest, r"^Walking to -0\.8, 0\.6$")
    await guest.until("document.querySelectorAll('.map-target').length === 1")
    await _says(guest, "^Arrived after|no sign of life")
    for _ in range(5):
        # On a very busy machine the dead man's switch stops what moves.
        if "no sign of life" in await guest.item("map-words").inner_text():
            await _click(guest, -0.8, 0.6)
            await _says(guest, "^Arrived after|no sign of life")
    assert await outcome(guest, "avatar/navigation", "start") == "OK"
    assert math.dist(await _figure(guest), (-0.8, 0.6)) < 0.1
    assert await guest.read("document.querySelectorAll('.map-target').length") == 0


@pytest.mark.long
async def test_avatar_comes_back_to_its_start(guest: Visit) -> None:
    await _figure(guest)
    await _click(guest, 0.6, 0.4)
    await _says(guest, "^Arrived after|no sign of life")
    for _ in range(5):
        await guest.press("map-back")
        await _says(guest, "^Walking to the front$")
        await _says(guest, "^Arrived after|no sign of life")
        if "no sign of life" not in await guest.item("map-words").inner_text():
            break
    assert math.dist(await _figure(guest), (0.0, 0.0)) < 0.1
    await expect(guest.item("map-back")).to_be_hidden()


async def test_walk_is_stopped_and_unreachable_place_is_named(guest: Visit) -> None:
    x, y = await _figure(guest)
    across, along = "Right" if x < -0.5 else "Left", "Up" if y < 0.5 else "Down"  # not towards a wall, wherever it is
    await guest.item("map").focus()
    before = len(guest.executed("avatar/navigation", "start"))
    for key in (f"Shift+Arrow{across}", f"Shift+Arrow{along}", "Enter"):
        await guest.page.keyboard.press(key)
    # Stopped any sooner, it would never have begun.
    await guest.until_executed("avatar/navigation", "start", before)
    await guest.press("map-stop")
    await _says(guest, "^(Stopped|.*stop)")
    assert await outcome(guest, "avatar/navigation", "start") == "ABORT"
    await _click(guest, 0.0, 4.1)
    await _says(guest, "is outside of the floor or inside an obstacle")
    assert await outcome(guest, "avatar/navigation", "start") == "ERROR"


async def test_the_red_button_and_its_key_stop_everything(guest: Visit) -> None:
    await _figure(guest)
    await _follow(guest)
    await guest.item("viewpoint").focus()
    await guest.page.keyboard.press("x")  # it stops from within a list, too
    await all_stopped(guest)
    await expect(guest.item("viewpoint")).to_have_value("automatic")
    assert await outcome(guest, "avatar/follower", "start") == "ABORT"
    await guest.press("stop-all")
    await all_stopped(guest)
    asked = [m["params"] for m in guest.sent if m["method"] == "openrois.stop_all"]
    assert len(asked) >= 2
    assert all(params == {"engine_id": "avatar"} for params in asked)


async def _follow(guest: Visit) -> None:
    """Follow the visitor, which goes on until it is ended."""
    await guest.until("document.querySelector('.map-thing.person')")
    # The visitor walks: where it was seen it may be no more.
    for _ in range(10):
        await guest.page.mouse.click(*await guest.read(_VISITOR))
        with suppress(AssertionError):
            await expect(guest.item("map-follow")).to_be_visible(timeout=2000)
            break
    await guest.press("map-follow")
    await _says(guest, "^Following visitor$")
    await guest.until_executed("avatar/follower", "start")


@pytest.mark.long
async def test_failed_stop_is_shown_until_the_next_one(guest: Visit) -> None:
    await _figure(guest)
    await guest.page.evaluate(_NO_STOP)
    button = guest.item("stop-all")
    await guest.press("stop-all")
    await expect(button).to_have_text("Not stopped")
    told = await guest.read("performance.now()")
    await guest.until(f"performance.now() > {told} + 5000")  # a success is told for 4 s
    await expect(button).to_have_text("Not stopped")
    await expect(button).to_have_attribute("title", "An arm: no answer")
    await guest.press("stop-all")
    await all_stopped(guest)


@pytest.mark.long
async def test_person_is_followed_until_stop(guest: Visit) -> None:
    await _figure(guest)
    await _follow(guest)
    await guest.press("map-stop")
    assert await outcome(guest, "avatar/follower", "start") == "ABORT"


@pytest.mark.long
async def test_closed_map_sends_no_queries(guest: Visit) -> None:
    await _figure(guest)
    await guest.press("map-open")
    await expect(guest.item("map")).to_be_hidden()
    mine = {"figure_moved", "floor_changed", "things_changed", "viewpoint_changed"}
    await guest.until("document.querySelector('[data-method=\"rois.event.unsubscribe\"]')")
    subscribed = [m for m in guest.sent if m["method"] == "rois.event.subscribe"]
    assert mine <= {m["params"]["event_type"] for m in subscribed}
    left = [m for m in guest.sent if m["method"] == "rois.event.unsubscribe"]
    assert len(left) == len(mine)


@pytest.mark.long
async def test_the_viewpoint_is_chosen_for_every_viewer(browser: Browser, guest: Visit, avatar: Demo) -> None:
    choice = guest.item("viewpoint")
    await expect(choice.locator("option")).to_have_text(["Automatic", "Face", "Room", "Follow"])
    async with visiting(browser, avatar.page) as other:
        await other.until("document.querySelector('[data-testid=viewpoint]')?.value === 'automatic'")
        await choice.select_option("room")
        assert await outcome(guest, "avatar/viewpoint", "choose") == "OK"
        await expect(other.item("viewpoint")).to_have_value("room")
    await choice.select_option("automatic")
    assert await outcome(guest, "avatar/viewpoint", "choose") == "OK"
