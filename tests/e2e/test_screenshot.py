"""The picture of the page in the README is a screenshot of the page: `OPENROIS_WRITE_SCREENSHOTS=1` writes it anew."""

import os
from pathlib import Path
from typing import Final

import cv2
import pytest
from playwright.async_api import expect

from tests.support.browser import Visit

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.timeout(120),
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "panda3d"

_README_PICTURE: Final = Path(__file__).parents[2] / "docs" / "demo.png"
_FIGURES: Final = """
    [...document.querySelectorAll("[data-role=figure-list] .spark path:last-child")]
        .every((path) => path.getAttribute("d").split("L").length > {points})
"""


async def test_the_page_is_worth_a_picture(guest: Visit, tmp_path: Path) -> None:
    write = os.environ.get("OPENROIS_WRITE_SCREENSHOTS") == "1"
    file = _README_PICTURE if write else tmp_path / "demo.png"
    await guest.item("say-text").fill("Hello! I am an avatar, live in your browser.")
    await guest.item("say-text").press("Enter")
    await guest.until(_FIGURES.format(points=40 if write else 2), within=60)
    await expect(guest.item("say-state")).to_contain_text("ompleted OK")
    await guest.page.get_by_role("button", name="Wave").click()
    await guest.plays(25)
    await guest.page.evaluate("scrollTo(0, 0)")
    await guest.page.screenshot(path=file)

    picture = cv2.imread(str(file))
    assert picture is not None
    assert picture.shape == (800, 1280, 3)
    assert picture.std() > 20
    assert not (await guest.look()).black
