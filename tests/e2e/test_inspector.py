"""The inspector: everything in a profile is shown and can be tried, for components that the page does not know."""

import asyncio
import re
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, expect

from openrois.adapter.dialer import serve_parent
from openrois.aio.tasks import TaskScope
from openrois.catalog.payload import Data
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.session.session import EngineHost
from openrois.types.profiles import component_urn
from openrois.types.references import engine_of
from tests.support.browser import GATEWAY_AWAY, PATIENCE, Visit, visiting
from tests.support.demo import free_port
from tests.support.deployment import application
from tests.support.fleet import everything, fleet
from tests.support.kettle import KETTLE, Boil, Kettle, kitchen
from tests.support.premises import running_avatar, running_gateway

pytestmark = [pytest.mark.browser, pytest.mark.long, pytest.mark.asyncio(loop_scope="session")]

_CONTRAST: Final = Path(__file__).with_name("contrast.js")
_KETTLE: Final = "#inspector/kitchen/kettle"
_SHOWN: Final = """(() => {
    const panel = document.querySelector(".panel");
    const fields = (part) => [...part.querySelectorAll("[data-field]")].map(({ dataset }) => dataset.field);
    const messages = (kind) => [...panel.querySelectorAll(`[data-kind=${kind}]`)].map((each) => ({
        name: each.dataset.name,
        arguments: fields(each),
        results: [...each.querySelectorAll(".gives")].map(({ textContent }) => textContent),
    }));
    return {
        ref: panel.dataset.ref,
        command: messages("command"),
        query: messages("query"),
        event: messages("event"),
        parameters: [...panel.querySelectorAll("[data-kind=parameters]")].flatMap(fields),
    };
})()"""
_PROFILE: Final = "openrois.client.getProfile()"


@pytest_asyncio.fixture(loop_scope="session")
async def gateway() -> AsyncIterator[Gateway]:
    async with running_gateway() as gateway:
        yield gateway


@pytest_asyncio.fixture(loop_scope="session")
async def kettle(gateway: Gateway) -> AsyncIterator[Kettle]:
    kettle = Kettle()
    async with fleet(_adapters(gateway), kitchen(kettle)):
        yield kettle


@pytest_asyncio.fixture(loop_scope="session")
async def visit(browser: Browser, gateway: Gateway, kettle: Kettle) -> AsyncIterator[Visit]:
    """The kettle's panel, opened."""
    async with visiting(browser, gateway.url + _KETTLE) as visit:
        await _shows(visit.page.locator("[data-ref='kitchen/kettle'] h2"), "kettle")
        yield visit


def _adapters(gateway: Gateway) -> str:
    return gateway.url.replace("http", "ws", 1) + "adapter"


async def _shows(locator: Locator, text: str | re.Pattern[str]) -> None:
    await expect(locator).to_contain_text(text, timeout=PATIENCE * 1000)


def _message(visit: Visit, kind: str, name: str) -> Locator:
    return visit.page.locator(f".panel [data-kind={kind}][data-name={name}]")


def _field(part: Visit | Locator, name: str) -> Locator:
    root = part.page.locator(".panel") if isinstance(part, Visit) else part
    return root.locator(f"[data-field={name}]")


async def _go(visit: Visit, ref: str) -> Locator:
    """Go to an engine or component and return its panel."""
    await visit.page.evaluate(f"location.hash = '#inspector/{ref}'")
    panel = visit.page.locator(f".panel[data-ref='{ref}'], .panel[data-engine='{ref}']")
    await expect(panel).to_be_visible(timeout=PATIENCE * 1000)
    return panel


def _expected(ref: str, profile: dict[str, Any]) -> dict[str, Any]:
    def messages(kind: str) -> list[dict[str, Any]]:
        return [
            {
                "name": each["name"],
                "arguments": [argument["name"] for argument in each.get("arguments", [])],
                "results": [f"{one['name']} {one['data_type_ref']['code']}" for one in each.get("results", [])],
            }
            for each in profile.get(f"{kind}_profiles", [])
        ]

    parameters = [each["name"] for each in profile.get("parameter_profiles", [])]
    kinds = {kind: messages(kind) for kind in ("command", "query", "event")}
    return {"ref": ref, **kinds, "parameters": parameters}


async def test_every_component_of_every_engine_is_shown_with_all_that_its_profile_lists(
    browser: Browser, gateway: Gateway, kettle: Kettle
) -> None:
    async with (
        fleet(_adapters(gateway), everything()),
        running_avatar(gateway),
        visiting(browser, f"{gateway.url}#inspector") as visit,
    ):
        for engine_id in ("robot", "kitchen", "avatar"):
            await expect(visit.page.locator(f".row[data-id={engine_id}]")).to_be_visible(timeout=PATIENCE * 1000)
        profiles = (await visit.read(_PROFILE))["component_profiles"]
        assert len(profiles) >= 17 + 1 + 2
        rows = await visit.read("[...document.querySelectorAll('.row')].map(({ dataset }) => dataset.id)")
        assert [each for each in rows if "/" in each] == sorted(profiles, key=engine_of)
        for ref, profile in profiles.items():
            panel = await _go(visit, ref)
            assert await visit.read(_SHOWN) == _expected(ref, profile)
            await _shows(
                panel.locator(".panel-ids"),
                component_urn(profile["identifier"]["code"], profile["identifier"]["authority"]),
            )
            await _shows(panel.get_by_test_id("component-status"), "Ready")
            assert await panel.locator(".chip").inner_text() == (profile.get("function") or "")


async def test_query_shows_its_results(visit: Visit) -> None:
    query = _message(visit, "query", "water_inside")
    await query.locator("[type=submit]").click()
    await _shows(query.locator(".outcome"), re.compile(r"OK\s*answered in [\d.]+ m?s"))
    await _shows(query.locator("[data-result=litres]"), re.compile(r"litres\s*1.5\s*double"))
    await expect(query.locator("[data-result=teas] li")).to_have_text(["green", "black"])


async def test_parameters_are_checked_as_they_are_typed_and_set_together(visit: Visit, kettle: Kettle) -> None:
    await visit.press("bind")
    target = _field(visit, "target")
    await expect(target.locator("input")).to_have_value("90")
    await target.locator("input").fill("9x")
    await _shows(target.locator(".problem"), "A whole number is expected")
    await target.locator("input").fill("75")
    await expect(target.locator(".problem")).to_be_empty()

    await _field(visit, "ratio").locator("input").fill("1e-3")
    await _field(visit, "keep_warm").locator("select").select_option("true")
    await _field(visit, "label").locator("textarea").fill("the blue one")
    await _field(visit, "wake_at").get_by_role("button", name="Now").click()
    minutes = _field(visit, "minutes")
    await minutes.get_by_role("button", name="Add item").click()
    await minutes.get_by_label("Item 3").fill("seven")
    await _shows(minutes.locator("li").nth(2), "A whole number is expected")
    await minutes.get_by_label("Item 3").fill("7")
    await minutes.get_by_role("button", name="Remove this item").first.click()
    await _field(visit, "whistle").locator("textarea").fill("loud")
    await visit.page.get_by_role("button", name="Set 7 parameters").click()
    await _shows(visit.page.locator("[data-kind=parameters] > .outcome:visible"), "set and completed after")
    await expect(visit.page.get_by_role("button", name="Set parameter")).to_be_disabled()
    changed = dict(kettle.parameters)
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z", changed.pop("wake_at"))
    assert changed.pop("minutes") == "[5,7]"
    assert changed == {
        "target": "75",
        "ratio": "1e-3",
        "keep_warm": "true",
        "label": "the blue one",
        "teas": '["green", "black"]',
        "whistle": "loud",
    }


async def test_a_command_is_refused_without_binding_and_runs_with_it(visit: Visit, kettle: Kettle) -> None:
    kettle.may_boil.clear()
    await visit.page.get_by_role("switch", name="Listen to water_boiled").click()
    command = _message(visit, "command", "boil_water")
    await _field(command, "degrees").locator("input").fill("95")
    await _field(command, "note").locator("textarea").fill("for two")
    await command.locator("[type=submit]").click()
    await _shows(command, re.compile("Refused.*has to be bound first"))

    await command.get_by_role("button", name="Bind and execute").click()
    await _shows(visit.item("bind-state"), "Bound by this page")
    await _shows(command.locator(".runs"), "Running since")
    await _shows(visit.item("component-status"), "Busy")
    kettle.may_boil.set()
    await _shows(command.locator("[data-result=note]"), "for two")
    await _shows(command.locator(".runs"), "completed after")
    await _shows(visit.item("component-status"), "Ready")

    heard = _message(visit, "event", "water_boiled").locator(".heard > li")
    await expect(heard).to_have_count(1)
    await heard.locator("summary").click()
    await _shows(heard.locator("[data-result=litres]"), "1.5")
    await heard.get_by_role("button", name="Ask for its details").click()
    await _shows(heard.locator(".outcome"), "the engine remembers")

    await visit.press("bind")
    await _shows(visit.item("bind-state"), "Not bound")
    await command.locator("[type=submit]").click()
    await _shows(command.locator(".runs > li").first, "Refused")


async def test_misfitting_value_is_sent_only_on_purpose(visit: Visit) -> None:
    await visit.press("bind")
    command = _message(visit, "command", "boil_water")
    await _field(command, "degrees").locator("input").fill("hot")
    await command.locator("[type=submit]").click()
    await expect(_field(command, "degrees").locator("input")).to_be_focused()
    await _shows(command, "A value does not fit its type.")
    assert not [each for each in visit.sent if each.get("method") == "rois.command.execute"]
    await command.get_by_role("button", name="Send it anyway").click()
    await _shows(command, re.compile("Not accepted.*does not accept these arguments"))


async def test_bind_is_refused_while_another_application_holds_the_component(visit: Visit, gateway: Gateway) -> None:
    async with application(gateway) as other:
        assert await other.code("rois.command.bind", component_ref="kitchen/kettle") == "OK"
        await visit.press("bind")
        await _shows(visit.page.locator(".panel-head .outcome"), "Another application has bound this component: ")
        await _shows(visit.item("bind-state"), "Not bound")


async def test_the_message_that_is_sent_can_be_seen_while_it_is_typed(visit: Visit) -> None:
    command = _message(visit, "command", "boil_water")
    await command.get_by_role("button", name="Show the message that is sent").click()
    await _field(command, "degrees").locator("input").fill("42")
    await _shows(command.locator("pre"), '"rois.command.execute"')
    await _shows(command.locator("pre"), re.compile(r'"name": "degrees",\s*"data_type_ref": "int",\s*"value": "42"'))


async def test_errors_are_shown_with_their_details(visit: Visit) -> None:
    await visit.press("bind")
    await _message(visit, "command", "burn_dry").locator("[type=submit]").click()
    await _shows(_message(visit, "command", "burn_dry"), re.compile("Failed.*went wrong: there is no water"))
    errors = visit.page.locator(".panel [data-group=errors]")
    await _shows(errors, "Component failed")
    await errors.locator("summary").click()
    await _shows(errors.locator("[data-result=description]"), "there is no water")
    panel = await _go(visit, "kitchen")
    await _shows(panel.locator("[data-group=errors]"), "Component failed")


async def test_a_command_is_stopped_by_another(visit: Visit, gateway: Gateway) -> None:
    async with fleet(_adapters(gateway), everything()):
        await expect(visit.page.locator(".row[data-id=robot]")).to_be_visible(timeout=PATIENCE * 1000)
        await _go(visit, "robot/follower")
        await visit.press("bind")
        await _message(visit, "command", "start").locator("[type=submit]").click()
        await _shows(visit.item("component-status"), "Busy")
        await _message(visit, "command", "stop").locator("[type=submit]").click()
        await _shows(_message(visit, "command", "start"), re.compile("Stopped.*Ended before it was done"))
        await _shows(_message(visit, "command", "stop"), "completed after")
        await _shows(visit.item("component-status"), "Ready")


async def test_what_was_typed_and_listened_to_survives_the_adapter(browser: Browser, gateway: Gateway) -> None:
    async with AsyncExitStack() as stack:
        async with fleet(_adapters(gateway), kitchen(Kettle())):
            visit = await stack.enter_async_context(visiting(browser, gateway.url + _KETTLE))
            await visit.press("bind")
            await visit.page.get_by_role("switch", name="Listen to water_boiled").click()
            command = _message(visit, "command", "boil_water")
            await _field(command, "degrees").locator("input").fill("81")
            await _field(visit, "target").locator("input").fill("82")
            await _field(visit, "label").locator("textarea").fill("mine")
        await _shows(visit.page.locator(".absent"), "This component has left.")
        await _shows(visit.page.locator(".row[data-id='kitchen/kettle']"), "away")
        await _shows(visit.item("component-status"), "Unknown")
        executed = [each for each in visit.sent if each.get("method") == "rois.command.execute"]
        await command.locator("[type=submit]").focus()
        await visit.page.keyboard.press("Enter")
        assert executed == [each for each in visit.sent if each.get("method") == "rois.command.execute"]

        again = Kettle()
        await stack.enter_async_context(fleet(_adapters(gateway), kitchen(again)))
        await expect(visit.page.locator(".absent")).to_be_hidden(timeout=PATIENCE * 1000)
        await _shows(visit.item("component-status"), "Ready")
        await _shows(visit.item("bind-state"), "Bound by this page")
        await expect(_field(visit, "target").locator("input")).to_have_value("82")
        await expect(_field(visit, "label").locator("textarea")).to_have_value("mine")
        await expect(_field(command, "degrees").locator("input")).to_have_value("81")
        await command.locator("[type=submit]").click()
        await _shows(command.locator(".runs"), "completed after")
        await expect(_message(visit, "event", "water_boiled").locator(".heard > li")).to_have_count(1)


async def test_what_was_typed_survives_another_profile_too(browser: Browser, gateway: Gateway) -> None:
    class MoreOfIt(Boil):
        cups: Annotated[int, Data("int")] = 2

    commands = tuple(replace(each, arguments=MoreOfIt) if each.arguments else each for each in KETTLE.commands)
    async with AsyncExitStack() as stack:
        async with fleet(_adapters(gateway), kitchen(Kettle())):
            visit = await stack.enter_async_context(visiting(browser, gateway.url + _KETTLE))
            command = _message(visit, "command", "boil_water")
            await _field(command, "degrees").locator("input").fill("81")
            query = _message(visit, "query", "water_inside")
            await query.locator("[type=submit]").click()
            await _shows(query.locator("[data-result=litres]"), "1.5")
        await _shows(visit.page.locator(".absent"), "This component has left.")
        await stack.enter_async_context(fleet(_adapters(gateway), kitchen(Kettle(replace(KETTLE, commands=commands)))))
        await expect(_field(command, "cups")).to_be_visible(timeout=PATIENCE * 1000)
        await expect(_field(command, "degrees").locator("input")).to_have_value("81")
        await _shows(query.locator("[data-result=litres]"), "1.5")


async def test_engines_below_engines(browser: Browser, gateway: Gateway) -> None:
    engine = await everything("robot").engine()
    await engine.attach(await kitchen(Kettle()).engine())
    async with AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        dialling = asyncio.create_task(serve_parent(EngineHost(engine, tasks), _adapters(gateway)))
        stack.push_async_callback(asyncio.wait, {dialling})
        stack.callback(dialling.cancel)
        visit = await stack.enter_async_context(visiting(browser, gateway.url + _KETTLE))
        await _shows(visit.item("component-status"), "Ready")
        levels = [("gateway", "1"), ("robot", "2"), ("kitchen", "3"), ("kitchen/kettle", "4")]
        for name, level in levels:
            await expect(visit.page.locator(f".row[data-id='{name}']")).to_have_attribute("aria-level", level)
        await visit.press("bind")
        command = _message(visit, "command", "boil_water")
        await _field(command, "degrees").locator("input").fill("95")
        await command.locator("[type=submit]").click()
        await _shows(command.locator(".runs"), "completed after")


async def test_a_gateway_that_goes_and_comes_back_takes_nothing_along(browser: Browser) -> None:
    settings = GatewaySettings(port=free_port())
    async with AsyncExitStack() as stack:
        async with run_gateway(settings) as gateway, fleet(_adapters(gateway), kitchen(Kettle())):
            page = visiting(browser, gateway.url + _KETTLE, tolerated=[GATEWAY_AWAY])
            visit = await stack.enter_async_context(page)
            await visit.press("bind")
            await _shows(visit.item("bind-state"), "Bound by this page")
            await visit.page.get_by_role("switch", name="Listen to water_boiled").click()
            await _field(visit, "target").locator("input").fill("82")
        await visit.banner("no-gateway", "The gateway does not answer")
        await _shows(visit.page.locator(".absent"), "There is no connection to the gateway.")
        await _shows(visit.item("bind-state"), "Not bound")
        await expect(_field(visit, "target").locator("input")).to_have_value("82")

        gateway = await stack.enter_async_context(run_gateway(settings))
        kettle = Kettle()
        await stack.enter_async_context(fleet(_adapters(gateway), kitchen(kettle)))
        await expect(visit.page.locator(".absent")).to_be_hidden(timeout=PATIENCE * 1000)
        await _shows(visit.item("bind-state"), "Bound by this page")
        await visit.page.get_by_role("button", name="Set parameter").click()
        await _shows(visit.page.locator("[data-kind=parameters] > .outcome:visible"), "set and completed after")
        assert kettle.parameters["target"] == "82"
        command = _message(visit, "command", "boil_water")
        await _field(command, "degrees").locator("input").fill("95")
        await command.locator("[type=submit]").click()
        await expect(_message(visit, "event", "water_boiled").locator(".heard > li")).to_have_count(1)


async def test_names_are_searched_and_the_tree_is_walked_with_the_keyboard(visit: Visit) -> None:
    keyboard = visit.page.keyboard
    await keyboard.press("/")
    await expect(visit.item("inspector-search")).to_be_focused()
    await keyboard.type("water_inside")
    row = visit.page.locator(".row[data-id='kitchen/kettle']")
    await _shows(row, "water_inside")
    await keyboard.press("ArrowDown")
    await expect(row).to_be_focused()
    await visit.item("inspector-search").fill("no such thing")
    await _shows(visit.page.locator(".tree-count"), "Nothing is found.")
    await visit.item("inspector-search").fill("")
    await row.focus()
    await keyboard.press("ArrowLeft")
    engine = visit.page.locator(".row[data-id=kitchen]")
    await expect(engine).to_be_focused()
    await keyboard.press("ArrowLeft")
    await expect(engine).to_have_attribute("aria-expanded", "false")
    await expect(row).to_be_hidden()
    await keyboard.press("Enter")
    await expect(visit.page.locator(".panel[data-engine=kitchen]")).to_be_visible()
    await keyboard.press("i")
    await expect(visit.item("stage")).to_be_visible()
    await visit.page.go_back()
    await expect(visit.page.locator(".panel[data-engine=kitchen]")).to_be_visible()


async def test_the_smallest_screen_shows_one_thing_at_a_time(
    browser: Browser, gateway: Gateway, kettle: Kettle
) -> None:
    phone = {"width": 360, "height": 740}
    async with visiting(browser, f"{gateway.url}#inspector", viewport=phone) as visit:
        row = visit.page.locator(".row[data-id='kitchen/kettle']")
        await row.click(timeout=PATIENCE * 1000)
        await expect(row).to_be_hidden()
        await expect(visit.page.get_by_role("heading", name="kettle", exact=True)).to_be_focused()
        assert await visit.read("document.documentElement.scrollWidth") == 360
        await visit.page.get_by_role("link", name="All components").click()
        await expect(row).to_be_visible()
        assert await visit.read("document.documentElement.scrollWidth") == 360


@pytest.mark.parametrize("scheme", ["light", "dark"])
async def test_every_text_can_be_read(browser: Browser, gateway: Gateway, kettle: Kettle, scheme: str) -> None:
    async with visiting(browser, gateway.url + _KETTLE, color_scheme=scheme) as visit:
        await _shows(visit.item("component-status"), "Ready")
        await _message(visit, "command", "boil_water").locator("[type=submit]").click()
        query = _message(visit, "query", "water_inside")
        await query.locator("[type=submit]").click()
        await _shows(query, "answered in")
        await _field(visit, "target").locator("input").fill("x")
        await visit.page.get_by_text("Profile as JSON").click()
        await visit.until("!document.getAnimations().some((each) => each instanceof CSSTransition)")
        found = await visit.page.evaluate(_CONTRAST.read_text())
        assert len(found) > 80
        assert [each for each in found if each["ratio"] < 4.5] == []


async def test_twenty_robots_are_shown_engine_by_engine(browser: Browser, gateway: Gateway) -> None:
    robots = [everything(f"robot_{number}") for number in range(20)]
    async with fleet(_adapters(gateway), *robots), visiting(browser, f"{gateway.url}#inspector") as visit:
        await _shows(visit.page.locator(".tree-count"), "340 components")
        assert await visit.page.locator(".row").count() == 1 + 20
        await visit.item("inspector-search").fill("robot_7 navigation")
        await expect(visit.page.locator(".row")).to_have_count(3)
        await visit.page.keyboard.press("Enter")
        await _shows(visit.page.locator(".panel h2"), "navigation")
        await visit.item("inspector-search").fill("")
        await expect(visit.page.locator(".row")).to_have_count(1 + 20 + 17)
        await expect(visit.page.locator(".row[aria-selected=true]")).to_be_in_viewport()
