"""`python -m tools.pictures`: takes the pictures of the documentation; `--check` names those that are out of date."""

import argparse
import asyncio
import sys
from typing import Final

from playwright.async_api import Browser, Page, expect

from tools.pictures.moving import filming
from tools.pictures.record import FOLDER, PICTURES, recorded, stale, write_record
from tools.pictures.stage import browser, demo, visit

__all__ = ["main"]

TAKEN: Final = ("demo.png", "map.png", "inspector.png", "demo.webp")
"""Those that are taken here; `tools.pictures.architecture` and `openrois_bench.charts` draw the others."""


_IN_VIEW: Final = 19
"""Components at the end of the inspector's tree that are seen there, and are asked how they fare."""


async def take() -> None:
    """Take all of them from one run of the demo."""
    with demo() as url:
        async with browser() as running:
            async with visit(running, url) as page:
                # The encoder finds out first what the way to the browser carries.
                await page.wait_for_timeout(6000)
                await _still(page)
                await _film(page)
            await _inspector(running, url)


async def _still(page: Page) -> None:
    """It waves, then it is on its way, and comes back."""
    await page.get_by_role("button", name="Wave").click()
    await page.wait_for_timeout(1300)
    await page.screenshot(path=FOLDER / "demo.png")
    await page.wait_for_timeout(3000)
    await _send(page, 0.3, 0.45)
    await page.get_by_test_id("map-words").filter(has_text="Walking").wait_for()
    await page.wait_for_timeout(1500)
    await page.screenshot(path=FOLDER / "map.png")
    await _arrived(page)
    await page.get_by_role("button", name="Come back").click()
    await page.get_by_test_id("map-words").filter(has_text="Walking").wait_for()
    await _arrived(page)


async def _film(page: Page) -> None:
    """The avatar says a sentence, and walks to where the floor map was clicked."""
    await page.wait_for_timeout(2000)
    async with filming(page) as film:
        await page.wait_for_timeout(600)
        await page.get_by_test_id("say-text").press_sequentially("Hello! I walk where you click.", delay=45)
        await page.get_by_test_id("say-text").press("Enter")
        await page.locator("[data-testid=say-state][data-state=done]").wait_for()
        await _send(page, 0.3, 0.5)
        await page.get_by_test_id("map-words").filter(has_text="Walking").wait_for()
        await _arrived(page)
        await page.wait_for_timeout(700)
    film.write(FOLDER / "demo.webp")


async def _arrived(page: Page) -> None:
    await page.get_by_test_id("map-words").filter(has_text="Arrived").wait_for()


async def _inspector(running: Browser, url: str) -> None:
    """The lamp of the tutorial."""
    async with visit(running, url) as page:
        await page.goto(f"{url}#inspector/lamp_1/lamp")
        await page.locator(".panel [data-kind=command][data-name=switch]").wait_for()
        dots = page.get_by_role("tree").locator(".dot")
        for row in range(1, _IN_VIEW):
            # How a component fares is shown as soon as that has been asked.
            await expect(dots.nth(-row)).not_to_have_attribute("data-status", "", timeout=30_000)
        await page.screenshot(path=FOLDER / "inspector.png")


async def _send(page: Page, across: float, down: float) -> None:
    floor = await page.get_by_test_id("map").bounding_box()
    if floor is None:
        raise RuntimeError("the floor map is not on the page")
    await page.mouse.click(floor["x"] + across * floor["width"], floor["y"] + down * floor["height"])


def main() -> None:
    """Take or check."""
    parser = argparse.ArgumentParser(prog="python -m tools.pictures", description=__doc__)
    parser.add_argument("--check", action="store_true", help="take none; name those whose sources have changed since")
    drawn = "record that these show the present state: drawn anew, or looked at and found right"
    parser.add_argument("--right", nargs="+", choices=PICTURES, default=[], metavar="PICTURE", help=drawn)
    wanted = parser.parse_args()
    if wanted.right:
        write_record(wanted.right)
    elif not wanted.check:
        asyncio.run(take())
        write_record(TAKEN)
    names = ", ".join(stale(recorded()))
    sys.exit(f"pictures that may show what is gone: {names}; run `make pictures`" if names else 0)


if __name__ == "__main__":
    main()
