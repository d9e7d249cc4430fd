"""No rule of WCAG 2.2 AA is broken in any state of the page, and touch targets are large enough."""

import re
from collections.abc import Sequence
from typing import Final, Literal

import pytest
from playwright.async_api import Browser, expect

from openrois.client import Client
from tests.support.accessibility import found_by_axe, too_small
from tests.support.browser import Visit, visiting
from tests.support.conversation import all_stopped, meet
from tests.support.demo import Demo
from tests.support.devices import Devices

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.usefixtures("node"),
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "puppet"

_NEVER_OPEN: Final = """window.WebSocket = class extends EventTarget {
    readyState = 0;
    bufferedAmount = 0;
    send() {}
    close() {}
};"""
_SIZES: Final = {"desktop": (1920, 1080), "laptop": (1366, 768), "phone": (390, 844), "landscape": (844, 390)}
_ALL: Final = [(size, scheme) for size in _SIZES for scheme in ("light", "dark")]
_ROVING: Final = "[...document.querySelectorAll('[data-testid=log] [tabindex=\"0\"]')].length"


async def _faultless(visit: Visit, state: str, looks: Sequence[tuple[str, str]]) -> None:
    """Check the page in these sizes and colours."""
    for size, scheme in looks:
        width, height = _SIZES[size]
        await visit.page.set_viewport_size({"width": width, "height": height})
        # Colours on their way to others are not what is looked at.
        shown: Literal["light", "dark"] = "dark" if scheme == "dark" else "light"
        await visit.page.emulate_media(color_scheme=shown, reduced_motion="reduce")
        assert await found_by_axe(visit.page) == [], (state, size, scheme)
        assert await too_small(visit.page, 24) == [], (state, size, scheme)


@pytest.mark.parametrize(
    "looks",
    [
        pytest.param([("phone", "dark")], id="one look"),
        pytest.param(_ALL, id="every look", marks=[pytest.mark.long, pytest.mark.timeout(600)]),
    ],
)
async def test_axe_reports_nothing_in_any_state_of_the_page(
    browser: Browser,
    devices: Devices,
    pocketsphinx: None,
    avatar: Demo,
    guest: Visit,
    looks: Sequence[tuple[str, str]],
) -> None:
    async with visiting(browser, avatar.page, script=_NEVER_OPEN) as waiting:
        await expect(waiting.item("connection")).to_have_attribute("data-state", "connecting")
        await _faultless(waiting, "connecting", looks)
    await _faultless(guest, "live", looks)
    await _share_the_legs(guest, avatar, looks)
    await _send_with_consent(guest, looks)
    await guest.press("control-toggle")
    await expect(guest.item("control-toggle")).to_have_attribute("aria-pressed", "true")
    await _faultless(guest, "driving", looks)
    async with visiting(browser, avatar.page) as other:
        await _meet_the_driven(other)
        await _faultless(other, "another visitor drives", looks)
    await guest.press("stop-all")
    await all_stopped(guest)
    await expect(guest.item("stopped-hand-back")).to_be_visible()
    await _faultless(guest, "stopped", looks)
    await guest.press("fullscreen")
    await guest.until("document.querySelector(':root:fullscreen')")
    assert await found_by_axe(guest.page) == []
    await guest.page.evaluate("document.exitFullscreen()")
    await guest.until("!document.fullscreenElement")
    await guest.page.evaluate("location.hash = '#inspector/avatar/speech_synthesizer'")
    await expect(guest.item("bind")).to_be_visible()
    await _faultless(guest, "inspector", looks)


async def _share_the_legs(visit: Visit, avatar: Demo, looks: Sequence[tuple[str, str]]) -> None:
    """Look at the parts of the body while a program has one of them, and while that is taken over."""
    legs = visit.page.locator("[data-part=legs]")
    async with Client(avatar.url) as program:
        await program.bind("avatar/navigation")
        take = legs.get_by_role("button", name="Take over")
        await expect(take).to_be_visible()
        await _faultless(visit, "a program has the legs", looks)
        await take.click()
        await expect(legs).to_contain_text("s left")
        await _faultless(visit, "the legs are taken over", looks)
        await legs.get_by_role("button", name="Hand back").click()
        await expect(take).to_be_visible()
    await expect(legs).to_contain_text("free")


async def _send_with_consent(visit: Visit, looks: Sequence[tuple[str, str]]) -> None:
    """Look at the consent while something is sent, and where there is none."""
    await visit.press("microphone-toggle")
    await expect(visit.item("consent-withdraw")).to_be_visible()
    await visit.press("hearing-switch")
    await expect(visit.page.locator("[data-role=card-operator]")).to_contain_text("listened to")
    await _faultless(visit, "microphone on, and listened to", looks)
    await visit.press("consent-withdraw")
    await expect(visit.item("consent-withdraw")).to_be_hidden()
    await _faultless(visit, "nothing consented to", looks)
    for purpose in ("live", "recognition"):
        await visit.item(f"consent-{purpose}").check()


async def _meet_the_driven(visit: Visit) -> None:
    """Wait until the page shows an avatar that another visitor drives."""
    await visit.plays(1)
    await expect(visit.item("handover")).to_contain_text(re.compile(r"visitor \d+ has control"))
    for name in ("viewpoint", "control-toggle"):
        await expect(visit.item(name)).to_be_disabled()


async def test_touch_targets_are_large_enough(browser: Browser, avatar: Demo) -> None:
    phone = {"width": 390, "height": 844}
    async with visiting(browser, avatar.page, viewport=phone, has_touch=True, is_mobile=True) as visit:
        await meet(visit)
        assert await too_small(visit.page, 44) == []
        await visit.page.evaluate("location.hash = '#inspector/avatar/speech_synthesizer'")
        await expect(visit.item("bind")).to_be_visible()
        assert await too_small(visit.page, 44) == []


async def test_message_log_is_one_tab_stop_with_arrow_keys(guest: Visit) -> None:
    keyboard = guest.page.keyboard
    rows = guest.page.locator("[data-role=log-row]")
    await guest.until("document.querySelectorAll('[data-role=log-row]').length > 10")
    assert await guest.read(_ROVING) == 1
    await guest.press("log-pause")  # so that the newest one stays that
    await guest.item("log-clear").focus()
    await keyboard.press("Tab")
    await expect(rows.last).to_be_focused()
    await keyboard.press("ArrowUp")
    await expect(rows.nth(await rows.count() - 2)).to_be_focused()
    await keyboard.press("Home")
    await expect(rows.first).to_be_focused()
    await keyboard.press("ArrowRight")
    await expect(guest.page.locator("[data-testid=log] details[open] pre")).to_have_count(1)
    await keyboard.press("ArrowLeft")
    await expect(guest.page.locator("[data-testid=log] details[open]")).to_have_count(0)
    assert await guest.read(_ROVING) == 1
    await keyboard.press("Shift+Tab")
    await expect(guest.item("log-clear")).to_be_focused()
    await keyboard.press("Tab")
    await expect(rows.first).to_be_focused()
