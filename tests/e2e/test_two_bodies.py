"""An avatar and a robot on one page: both are seen, driven and stopped, large or side by side."""

import asyncio
import math
import re
from collections.abc import AsyncIterator, Iterator
from typing import Final

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, expect

from openrois.client import Client
from openrois.client.components import SystemInformation
from tests.support.accessibility import found_by_axe, too_small
from tests.support.browser import PATIENCE, Visit, visiting
from tests.support.conversation import all_stopped
from tests.support.demo import Demo, hand_back, running_demo

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.usefixtures("node"),
    pytest.mark.asyncio(loop_scope="session"),
]

MOVED: Final = 0.4
"""Metres from where a body began that show that it was driven: the page, too, says that it is away from there."""


class TwoBodies:
    """The page with both bodies, and an application that knows where they are."""

    def __init__(self, visit: Visit, client: Client) -> None:
        self.visit = visit
        self.large = visit.page.locator("[data-role=scene]")
        self.card = visit.item("body-card")
        self._client = client

    async def place(self, engine_id: str) -> tuple[float, float]:
        """Where a body is, in metres."""
        system = SystemInformation(self._client, f"{engine_id}/system_info")
        x, y, *_ = map(float, (await system.robot_position()).position_data[0].split(","))
        return x, y

    async def drive(self, part: Locator, engine_id: str) -> None:
        """Take control in a part of the page, and go ahead until the body has moved."""
        toggle = part.get_by_test_id("control-toggle")
        await toggle.click(timeout=PATIENCE * 1000)
        await expect(toggle).to_have_attribute("aria-pressed", "true", timeout=PATIENCE * 1000)
        begin = await self.place(engine_id)
        await self.visit.page.keyboard.down("ArrowUp")
        async with asyncio.timeout(PATIENCE):
            while math.dist(begin, await self.place(engine_id)) < MOVED:
                pass
        await self.visit.page.keyboard.up("ArrowUp")


async def live(part: Locator) -> None:
    """Wait until a part of the page shows live pictures."""
    await expect(part.get_by_test_id("stage")).to_have_attribute("data-look", "live", timeout=PATIENCE * 1000)


@pytest.fixture(scope="module")
def demo(panda3d: None, chromium: object, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    with running_demo(tmp_path_factory.mktemp("bodies"), "panda3d", ("--with", "robot")) as demo:
        yield demo


@pytest_asyncio.fixture(loop_scope="session")
async def bodies(browser: Browser, demo: Demo) -> AsyncIterator[TwoBodies]:
    options = {"viewport": {"width": 1500, "height": 900}}
    async with Client(demo.url) as client, visiting(browser, demo.page, **options) as visit:  # type: ignore[arg-type]
        both = TwoBodies(visit, client)
        await live(both.large)
        await live(both.card)
        yield both
    await hand_back(demo)


async def test_both_are_seen_and_driven_and_stop_stops_them(bodies: TwoBodies) -> None:
    await expect(bodies.card.locator("[data-role=body-name]")).to_have_text("robot")
    await expect(bodies.card.get_by_test_id("map-words")).to_have_text(re.compile("Click where it should go"))
    await bodies.drive(bodies.card, "robot")
    await bodies.drive(bodies.large, "avatar")
    await bodies.visit.press("stop-all")
    await all_stopped(bodies.visit)
    for part in (bodies.card, bodies.large):
        await expect(part.get_by_test_id("control-toggle")).to_have_attribute(
            "aria-pressed", "false", timeout=PATIENCE * 1000
        )


@pytest.mark.long
async def test_a_map_sends_the_body_whose_map_it_is(bodies: TwoBodies) -> None:
    back = bodies.card.get_by_test_id("map-back")
    if not await back.is_visible():
        await bodies.drive(bodies.card, "robot")
        await bodies.card.get_by_test_id("control-toggle").click()
    avatar = await bodies.place("avatar")
    await expect(back).to_have_text("To the dock")
    await back.click(timeout=PATIENCE * 1000)
    await expect(bodies.card.get_by_test_id("map-words")).to_have_text(
        re.compile(r"^Arrived after"), timeout=PATIENCE * 1000
    )
    assert math.dist(avatar, await bodies.place("avatar")) < MOVED


async def test_they_stand_side_by_side_or_one_is_large(bodies: TwoBodies) -> None:
    visit = bodies.visit

    async def widths() -> list[float]:
        return [
            box["width"]
            for part in (bodies.large, bodies.card)
            if (box := await part.get_by_test_id("stage").bounding_box())
        ]

    large, small = await widths()
    assert large > 2 * small
    await visit.press("layout-toggle")
    large, small = await widths()
    assert 0.8 < large / small < 1.25
    assert await found_by_axe(visit.page) == []
    assert await too_small(visit.page, 24) == []

    await bodies.card.get_by_test_id("body-enlarge").click()
    await expect(visit.item("avatar-select")).to_have_value("robot")
    await expect(bodies.card.locator("[data-role=body-name]")).to_have_text("avatar")
    await live(bodies.large)
    await live(bodies.card)

    await visit.page.reload()
    await live(bodies.large)
    await live(bodies.card)
    large, small = await widths()
    assert 0.8 < large / small < 1.25, "the page remembers it"
    await visit.press("layout-toggle")
