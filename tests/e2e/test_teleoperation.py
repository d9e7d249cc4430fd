"""The operator drives the avatar; it stops when the operator's page is hidden or closed."""

import re
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from openrois_avatar.link.messages import Drive, Halt, Look
from openrois_body.teleoperation import pilot
from playwright.async_api import Browser, expect

from tests.support.browser import PATIENCE, Visit, visiting
from tests.support.guarded import fresh
from tests.support.operated import NotingEngine, operated_avatar

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]


class Drivers:
    """The page of an avatar whose game engine takes notes."""

    def __init__(self, visit: Visit, engine: NotingEngine) -> None:
        self.visit = visit
        self.engine = engine

    async def take_control(self) -> None:
        await self.visit.press("control-toggle")
        await expect(self.visit.item("control-toggle")).to_have_attribute(
            "aria-pressed", "true", timeout=PATIENCE * 1000
        )

    async def goes(self) -> None:
        """Wait until the figure is driven anew."""
        count = len(self.engine.times(Drive))
        await self.engine.until(lambda: len(self.engine.times(Drive)) > count + 1)

    async def stands(self) -> None:
        """Wait until the figure was halted after the last time that it was driven."""
        await self.engine.until(
            lambda: self.engine.times(Halt) and self.engine.times(Halt)[-1] > self.engine.times(Drive)[-1]
        )


@pytest_asyncio.fixture(loop_scope="session")
async def drivers(browser: Browser, tmp_path: Path) -> AsyncIterator[Drivers]:
    # A token left from another gateway has no effect at one without tokens.
    left = f"#token={fresh(roles='viewer')}"
    async with (
        operated_avatar(tmp_path) as (gateway, engine),
        visiting(browser, gateway.url + left) as visit,
    ):
        await visit.until("openrois.video?.status === 'STREAMING_RUNNING'")
        yield Drivers(visit, engine)


async def test_keyboard_drives_and_a_hidden_page_releases_everything(drivers: Drivers) -> None:
    visit, engine = drivers.visit, drivers.engine
    await drivers.take_control()
    await visit.page.keyboard.down("ArrowUp")
    await drivers.goes()
    assert all(command.ahead == 0.8 for _, command in engine.heard if isinstance(command, Drive))
    await visit.page.keyboard.up("ArrowUp")
    await drivers.stands()

    await visit.page.keyboard.down("KeyA")
    await drivers.goes()
    hide = "Object.defineProperty(document, 'visibilityState', {value: 'hidden', configurable: true})"
    await visit.page.evaluate(f"{hide} && document.dispatchEvent(new Event('visibilitychange'))")
    await drivers.stands()
    assert engine.inputs[-1] in {"release", "state"}
    await expect(visit.item("control-words")).to_have_text("The operator's page was hidden")

    await visit.page.evaluate("delete document.visibilityState")
    await visit.page.keyboard.up("KeyA")
    await visit.page.keyboard.press("Escape")
    await expect(visit.item("control-toggle")).to_have_attribute("aria-pressed", "false")
    driven = len(engine.times(Drive))
    await visit.page.keyboard.press("KeyW")
    await visit.until_executed("avatar/teleoperation", "stop")
    assert len(engine.times(Drive)) == driven


@pytest.mark.long
async def test_a_key_held_while_another_visitor_stops_the_avatar_has_to_be_pressed_anew(
    browser: Browser, drivers: Drivers
) -> None:
    visit, engine = drivers.visit, drivers.engine
    driving = visit.item("control-toggle")
    await drivers.take_control()
    await visit.page.keyboard.down("KeyW")
    await drivers.goes()
    async with visiting(browser, visit.page.url) as other:
        await other.press("stop-all")
    await expect(driving).to_have_attribute("aria-pressed", "false", timeout=PATIENCE * 1000)
    await drivers.stands()
    driven = len(engine.times(Drive))

    await drivers.take_control()
    await visit.page.keyboard.down("KeyW")  # it is held on: this one is a repetition
    await visit.page.keyboard.press("Escape")
    await visit.until_executed("avatar/teleoperation", "stop")
    await expect(driving).to_have_attribute("aria-pressed", "false")
    assert len(engine.times(Drive)) == driven

    await visit.page.keyboard.up("KeyW")
    await drivers.take_control()
    await visit.page.keyboard.down("KeyW")
    await drivers.goes()


_PAD = """
    const buttons = Array.from({ length: 17 }, () => ({ pressed: false, value: 0 }));
    const id = "Stick 2000 (STANDARD GAMEPAD)";
    const pad = { id, connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons };
    navigator.getGamepads = () => [pad];
    window.push = (ahead) => { pad.axes[1] = -ahead; };
    dispatchEvent(new Event("gamepadconnected"));
"""


@pytest.mark.long
async def test_a_gamepad_is_announced_and_drives(drivers: Drivers) -> None:
    visit, engine = drivers.visit, drivers.engine
    await visit.page.evaluate(f"() => {{ {_PAD} }}")
    words = visit.item("control-words")
    await expect(words).to_have_text("Stick 2000 is connected: take control to drive")
    await drivers.take_control()
    await expect(words).to_have_text("You have control, with Stick 2000")
    await expect(visit.item("control-legend")).to_contain_text("Left stick")
    await visit.page.evaluate("push(1)")
    await drivers.goes()
    await visit.page.evaluate("push(0)")
    await drivers.stands()
    assert all(command.ahead > 0 for _, command in engine.heard if isinstance(command, Drive))


async def test_driver_holds_the_whole_body_and_hands_over_all_of_it(browser: Browser, drivers: Drivers) -> None:
    mine = drivers.visit
    async with visiting(browser, mine.page.url) as theirs:
        await theirs.until("openrois.video?.status === 'STREAMING_RUNNING'")
        await expect(theirs.item("control-toggle")).to_be_enabled()
        await drivers.take_control()
        strip = theirs.item("handover")
        await expect(strip).to_contain_text("Another visitor has control")
        await expect(theirs.item("control-toggle")).to_be_disabled()
        await expect(theirs.item("map")).to_have_attribute("aria-disabled", "true")
        await expect(theirs.item("map-words")).to_have_text("Another visitor has control.")
        assert await theirs.read("document.querySelectorAll('button.reaction:enabled').length") == 0
        assert not await theirs.read("document.querySelector('[data-testid=stage]').classList.contains('looks')")
        assert await _holding(theirs) == {"HELD"}

        await theirs.press("handover-yes")
        await expect(mine.item("handover")).to_contain_text("Another visitor asks for control")
        await mine.press("handover-yes")
        await expect(theirs.item("control-toggle")).to_have_attribute("aria-pressed", "true")
        await expect(mine.item("control-toggle")).to_be_disabled()
        assert await _holding(theirs) == {"MINE"}
        await theirs.press("control-toggle")
        await expect(mine.item("control-toggle")).to_be_enabled()
        await expect(mine.item("map")).not_to_have_attribute("aria-disabled", "true")
        for bar in (mine.item("handover"), strip):
            await expect(bar).to_be_hidden()


async def _holding(visit: Visit) -> set[str]:
    """Return the page's lease of each component that moves the body."""
    refs = ["teleoperation", "navigation", "move", "follower", "reaction"]
    ask = f"Promise.all({refs}.map((name) => openrois.client.control.status(`avatar/${{name}}`)))"
    return {each["state"] for each in await visit.page.evaluate(ask)}


async def test_a_finger_walks_with_the_stick_and_another_one_looks(browser: Browser, drivers: Drivers) -> None:
    phone = {"width": 390, "height": 844}
    await drivers.visit.page.close()
    async with visiting(browser, drivers.visit.page.url, viewport=phone, has_touch=True, is_mobile=True) as visit:
        await visit.until("openrois.video?.status === 'STREAMING_RUNNING'")
        held = Drivers(visit, drivers.engine)
        await expect(visit.item("stick")).to_be_hidden()
        await held.take_control()
        await expect(visit.item("control-legend")).to_have_text(re.compile("Stick.*Drag"))
        stick, picture = [await visit.item(name).bounding_box() for name in ("stick", "avatar-video")]
        assert stick is not None
        assert picture is not None
        x, y = stick["x"] + stick["width"] / 2, stick["y"] + stick["height"] / 2
        touch = await visit.page.context.new_cdp_session(visit.page)

        async def fingers(kind: str, *at: tuple[float, float]) -> None:
            points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(at)]
            await touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        await fingers("touchStart", (x, y))
        await fingers("touchMove", (x, y - 60))
        await held.goes()
        eyes = (picture["x"] + picture["width"] * 0.9, picture["y"] + picture["height"] * 0.4)
        before = len(drivers.engine.times(Look))
        await fingers("touchStart", (x, y - 60), eyes)
        await drivers.engine.until(lambda: len(drivers.engine.times(Look)) > before)
        await held.goes()
        await fingers("touchEnd")
        await held.stands()
        assert all(each.ahead > 0 and each.turn == 0 for _, each in drivers.engine.heard if isinstance(each, Drive))
        assert await visit.read("scrollY") == 0


@pytest.mark.long
async def test_input_survives_a_new_media_path_and_a_closed_page_releases_everything(
    drivers: Drivers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pilot, "PATIENCE", 5.0)  # a slow machine may stall for longer than a hand may be silent
    visit = drivers.visit
    await drivers.take_control()
    await visit.page.keyboard.down("KeyW")
    await drivers.goes()
    before = visit.told("signaling.offer")[0]["peer_id"]
    await visit.read(f"openrois.client.call('signaling.restart', {{peer_id: '{before}'}})")
    await visit.until_told("signaling.offer", replaces=before)
    await visit.until_told("signaling.bye", peer_id=before)
    await drivers.goes()
    assert drivers.engine.times(Halt) == []
    await visit.page.close()
    await drivers.stands()
