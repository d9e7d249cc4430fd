"""Profiles of unknown adapters in the inspector: text of bounded size, and events that come fast."""

from typing import Any, Final

import pytest
from playwright.async_api import Browser, expect

from tests.support.browser import PATIENCE, visiting
from tests.support.plain import attached, engine_profile, plain_adapter, profile_result
from tests.support.premises import running_gateway

pytestmark = [pytest.mark.browser, pytest.mark.long, pytest.mark.asyncio(loop_scope="session")]

_MARKUP: Final = '<img src="x" onerror="harm()"><script>harm()</script>'
_LONG: Final = "n" * 10_000
_BURST: Final = 120
_INSPECTED: Final = "#inspector/plain/toy"
_CARDS: Final = """(kind) => ({
    told: document.querySelector(`[data-group=${kind}] .count`).textContent,
    shown: String(document.querySelectorAll(`[data-group=${kind}] .message`).length),
})"""


def _value(text: str) -> dict[str, Any]:
    return {"name": text, "data_type_ref": {"code": text}, "default_value": text, "description": text}


def _naming_all(text: str, count: int = 1) -> dict[str, Any]:
    """Return a result of `get_profile` in which every name is this one and each message appears `count` times."""
    message = {"name": text, "results": [_value(text)]}
    component = {
        "identifier": {"code": text},
        "name": text,
        "sub_component_profiles": [text],
        "command_profiles": [{**message, "arguments": [_value(text)]}] * count,
        "query_profiles": [message] * count,
        "event_profiles": [message] * count,
        "parameter_profiles": [_value(text)],
    }
    return {
        "return_code": "OK",
        "profile": engine_profile("plain", "plain/toy"),
        "component_profiles": {"plain/toy": component},
    }


async def test_markup_is_text(browser: Browser) -> None:
    results = [{"name": _MARKUP, "data_type_ref": _MARKUP, "value": _MARKUP}]
    async with (
        running_gateway() as gateway,
        plain_adapter(gateway, _naming_all(_MARKUP), query__query={"return_code": "OK", "results": results}),
    ):
        await attached(gateway)
        async with visiting(browser, gateway.url + _INSPECTED) as visit:
            query = visit.page.locator("[data-kind=query]")
            await query.locator("[type=submit]").click(timeout=PATIENCE * 1000)
            await expect(query.locator(".result .value")).to_have_text(_MARKUP)
            await expect(query.locator("h4")).to_have_text(_MARKUP)
            assert await visit.page.locator(".inspector :is(img, script)").count() == 0


async def test_endless_names_take_a_part_of_the_screen(browser: Browser) -> None:
    async with running_gateway() as gateway, plain_adapter(gateway, _naming_all(_LONG)):
        await attached(gateway)
        async with visiting(browser, gateway.url + _INSPECTED) as visit:
            await expect(visit.page.locator("[data-kind=event] h4")).to_have_text(_LONG, timeout=PATIENCE * 1000)
            for selector in (".panel-ids > *", ".message-title", ".field"):
                for each in await visit.page.locator(selector).all():
                    box = await each.bounding_box()
                    # What was drawn anew meanwhile has none.
                    assert box is None or box["height"] <= 300, selector
            assert await visit.read("document.documentElement.scrollWidth <= innerWidth")


async def test_what_stands_twice_is_shown_and_counted_once(browser: Browser) -> None:
    async with running_gateway() as gateway, plain_adapter(gateway, _naming_all("same", 2)):
        await attached(gateway)
        async with visiting(browser, gateway.url + _INSPECTED) as visit:
            await expect(visit.page.locator("[data-kind=event] h4")).to_have_text("same", timeout=PATIENCE * 1000)
            for kind in ("commands", "queries", "events"):
                assert await visit.page.evaluate(_CARDS, kind) == {"told": "1", "shown": "1"}


async def test_a_flood_of_events(browser: Browser) -> None:
    subscribed = {"return_code": "OK", "subscribe_id": "plain/sub"}
    async with running_gateway() as gateway, plain_adapter(gateway, event__subscribe=subscribed) as adapter:
        await attached(gateway)
        async with visiting(browser, gateway.url + _INSPECTED) as visit:
            card = visit.page.locator("[data-kind=event][data-name=laughed]")
            await card.get_by_role("switch").click(timeout=PATIENCE * 1000)
            # What was asked later and is answered tells that it listens.
            query = visit.page.locator("[data-kind=query][data-name=mood]")
            await query.locator("[type=submit]").click()
            await expect(query).to_contain_text("answered in", timeout=PATIENCE * 1000)
            for heard in range(_BURST, 5 * _BURST, _BURST):
                for number in range(_BURST):
                    await adapter.tell_event("plain/sub", "laughed", f"plain/evt-{heard + number}")
                await expect(card).to_contain_text(f"{heard} heard", timeout=PATIENCE * 1000)
            await expect(card).to_contain_text("the newest 100 are kept")
            await expect(card.locator(".heard > li")).to_have_count(100)


async def test_of_components_that_leave_only_those_that_were_opened_are_kept(browser: Browser) -> None:
    async with (
        running_gateway() as gateway,
        plain_adapter(gateway, profile_result("opened", "ignored")) as adapter,
    ):
        await attached(gateway)
        async with visiting(browser, f"{gateway.url}#inspector/plain/opened") as visit:
            place = visit.page.locator(".place")
            await expect(place.locator("h2")).to_have_text("opened", timeout=PATIENCE * 1000)
            adapter.profile = profile_result("other")
            await adapter.tell("rois.system.profile_changed")
            await expect(place).to_contain_text("has left", timeout=PATIENCE * 1000)
            await visit.page.evaluate("location.hash = '#inspector/plain/ignored'")
            await expect(place).to_contain_text("There is no component plain/ignored here")
            await visit.page.evaluate("location.hash = '#inspector/plain/opened'")
            await expect(place).to_contain_text("has left")
