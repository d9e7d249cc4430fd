"""What axe-core finds on a page (WCAG 2.2 A and AA, and best practice), and what is too small for a finger."""

from pathlib import Path
from typing import Final

from playwright.async_api import Page

__all__ = ["found_by_axe", "too_small"]

_AXE: Final = Path(__file__).parents[2] / "web_demo" / "node_modules" / "axe-core" / "axe.min.js"
_TAGS: Final = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
_RUN: Final = """async (tags) => {
    const { violations } = await axe.run(document, { runOnly: tags, resultTypes: ["violations"] });
    return violations.flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target}`));
}"""
_SMALL: Final = """(least) => [...document.querySelectorAll("a, button, input, select, summary, [tabindex='0']")]
    .filter((each) => each.checkVisibility({ visibilityProperty: true }) && !each.closest(".skip, .visually-hidden"))
    .filter((each) => {
        const { width, height } = each.getBoundingClientRect();
        return width > 0 && (width < least || height < least);
    }).map(({ outerHTML }) => outerHTML.slice(0, 100))"""


async def found_by_axe(page: Page) -> list[str]:
    """Return each broken rule and its place; the page is scrolled to its top."""
    await page.evaluate("scrollTo(0, 0)")
    if not await page.evaluate("'axe' in window"):
        await page.evaluate(_AXE.read_text())
    found: list[str] = await page.evaluate(_RUN, _TAGS)
    return found


async def too_small(page: Page, least: int) -> list[str]:
    """Return controls that are smaller than so many CSS pixels."""
    found: list[str] = await page.evaluate(_SMALL, least)
    return found
