"""The page and some hundred bodies: listed in pages, found by their ids, and asked about where they are shown."""

import re
from collections.abc import AsyncIterator
from typing import Any, Final, cast

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.types.references import engine_of
from tests.support.accessibility import found_by_axe, too_small
from tests.support.browser import Visit, visiting
from tests.support.deployment import application
from tests.support.fleet import Part
from tests.support.premises import running_gateway

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

COUNT: Final = 300
PAGE: Final = 50
TYPES: Final = ("Navigation", "Reaction", "SpeechSynthesis")


def robot(number: int) -> LocalRegistry:
    """A robot that acts, and cannot be seen."""
    parts = [Part(kind) for kind in BASIC_COMPONENTS if kind.code in TYPES]
    # A registry asks for nothing but the run-time face of a component.
    return LocalRegistry(f"robot-{number:03}", cast(Any, parts))


@pytest_asyncio.fixture(loop_scope="session")
async def gateway() -> AsyncIterator[Gateway]:
    async with running_gateway() as gateway:
        for number in range(COUNT):
            await gateway.engine.attach(robot(number))
        yield gateway


def asked(visit: Visit, method: str) -> list[dict[str, Any]]:
    """Return the params of all requests of a method so far."""
    return [message["params"] for message in visit.sent if message.get("method") == method]


async def test_hundreds_of_bodies_are_listed_found_and_followed(browser: Browser, gateway: Gateway) -> None:
    async with visiting(browser, gateway.url) as visit:
        rows = visit.item("body-rows").locator("li")
        search, count, select = (visit.item(name) for name in ("body-search", "body-count", "avatar-select"))
        await expect(rows).to_have_count(PAGE)
        await expect(count).to_have_text(f"{PAGE} of {COUNT - 1} are shown")
        await expect(select).to_have_value("robot-000")
        await expect(select.locator("option")).to_have_count(PAGE + 1)
        await expect(rows.first).to_have_text(re.compile("robot-001.*Free"))
        assert asked(visit, "rois.system.get_profile") == asked(visit, "openrois.directory.profiles") == []
        assert await visit.item("body-card").count() == 0
        asked_about = {engine_of(each["component_ref"]) for each in asked(visit, "openrois.lease.query")}
        assert asked_about <= {f"robot-{number:03}" for number in range(PAGE + 1)}
        assert await found_by_axe(visit.page) == []
        assert await too_small(visit.page, 24) == []

        await visit.press("body-more")
        await expect(rows).to_have_count(2 * PAGE)
        await expect(rows.nth(PAGE).get_by_role("button")).to_be_focused()

        await search.fill("ROBOT 27")
        await expect(rows).to_have_count(13)
        await expect(visit.item("body-more")).to_be_hidden()
        found = rows.and_(visit.page.locator("[data-engine=robot-277]"))
        async with application(gateway) as other:
            assert await other.code("rois.command.bind", component_ref="robot-277/navigation") == "OK"
            await expect(found).to_have_text(re.compile("Another visitor has control"))
        await expect(found).to_have_text(re.compile("Free"))
        await found.get_by_role("button").click()
        await expect(select).to_have_value("robot-277")
        await expect(rows).to_have_count(12)

        await search.fill("robot-9")
        await expect(count).to_have_text("Nothing is found.")
        later = robot(987)
        await gateway.engine.attach(later)
        await expect(rows).to_have_text(re.compile("robot-987.*Free"))
        gateway.engine.detach(later)
        await expect(rows).to_have_count(0)
        assert asked(visit, "rois.system.get_profile") == []
        assert len(asked(visit, "openrois.directory.list")) == COUNT // 100 + 1


async def test_the_inspector_loads_what_is_opened_of_hundreds_of_bodies(browser: Browser, gateway: Gateway) -> None:
    async with visiting(browser, f"{gateway.url}#inspector") as visit:
        rows, search = visit.page.locator(".row"), visit.item("inspector-search")
        await expect(visit.page.locator(".tree-count")).to_have_text(f"{COUNT * len(TYPES)} components")
        await expect(rows).to_have_count(200)
        await visit.page.get_by_role("button", name="Show 101 more").click()
        await expect(rows).to_have_count(1 + COUNT)
        await expect(visit.page.locator(".panel[data-engine=gateway] .link-row")).to_have_count(PAGE)
        assert asked(visit, "openrois.directory.profiles") == []

        await visit.page.evaluate("location.hash = '#inspector/robot-250/navigation'")
        await expect(visit.page.locator("[data-ref='robot-250/navigation'] [data-kind=command]").first).to_be_visible()
        await expect(visit.page.locator(".row[aria-selected=true]")).to_be_in_viewport()
        await expect(visit.item("component-status")).to_have_text("Ready")
        # A word that stands in profiles alone: of each type one is read, for all bodies.
        await search.fill("target_positions robot-12")
        await expect(rows).to_have_count(1 + 2 * 10)
        read = [ref for each in asked(visit, "openrois.directory.profiles") for ref in each["component_refs"]]
        assert len(read) == len(TYPES)
        assert [each["condition"] for each in asked(visit, "rois.system.get_profile")] == [
            "component_ref LIKE 'gateway/%'"
        ]


@pytest.mark.long
async def test_bodies_with_cards_become_a_list_once_there_are_too_many(browser: Browser) -> None:
    async with running_gateway() as gateway, application(gateway) as other, visiting(browser, gateway.url) as visit:
        robots = [robot(number) for number in range(PAGE + 2)]
        for each in robots[:3]:
            await gateway.engine.attach(each)
        cards, listed = visit.item("body-card"), visit.item("body-list")
        await expect(cards).to_have_count(2)
        await expect(listed).to_be_hidden()
        # One is asked for, and keeps its card until that is over.
        assert await other.code("rois.command.bind", component_ref="robot-002/navigation") == "OK"
        asked_for = cards.and_(visit.page.locator("[data-engine=robot-002]"))
        await asked_for.get_by_role("button", name="Ask for it").click()
        await expect(asked_for).to_contain_text("You wait for control")
        for each in robots[3:]:
            await gateway.engine.attach(each)
        await expect(visit.item("body-rows").locator("li")).to_have_count(PAGE)
        await expect(visit.item("body-count")).to_have_text(f"{PAGE} of {PAGE + 1} are shown")
        await expect(cards).to_have_count(1)
        await asked_for.get_by_role("button", name="Leave").click()
        await expect(cards).to_have_count(0)
        gateway.engine.detach(robots[-1])
        await expect(cards).to_have_count(PAGE)
        await expect(listed).to_be_hidden()
