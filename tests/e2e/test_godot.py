"""`openrois demo --engine godot`: a viewer in a browser sees what Godot draws, and Godot obeys."""

import re
from pathlib import Path
from typing import Final

import cv2
import numpy as np
import pytest
from playwright.async_api import expect

from tests.support.browser import Visit
from tests.support.conversation import outcome

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE: Final = "godot"
_MOVED: Final = 1.0
"""By how much a picture differs from an earlier one, in luma and on average, when the avatar makes a gesture."""


@pytest.mark.long
async def test_the_page_shows_godot_and_godot_obeys_the_page(guest: Visit, tmp_path: Path) -> None:
    await guest.plays(10)
    await guest.watch("picture", 0.0, 0.0, 1.0, 0.94)
    await guest.listen()
    await guest.page.get_by_role("button", name="Wave").click()
    # First what goes away after some seconds: what was seen and heard is kept.
    await expect(guest.item("reaction-state")).to_have_text(re.compile(r"^Wave: done after"))
    await guest.until(f"probe.watched.picture.some(({{ away }}) => away > {_MOVED})")
    await guest.until("probe.sound.some(({ rms }) => rms > 0.01)")
    await guest.page.screenshot(path=tmp_path / "godot.png")
    assert await outcome(guest, "avatar/reaction", "start") == "OK"
    # The figure's shirt is blue, in the middle of the picture.
    box = await guest.item("stage").bounding_box()
    picture = cv2.imdecode(np.frombuffer(await guest.page.screenshot(clip=box), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    height, width, _ = picture.shape
    shirt = picture[int(0.42 * height) : int(0.52 * height), int(0.47 * width) : int(0.53 * width)]
    blue, _, red = (float(channel.mean()) for channel in cv2.split(shirt))
    assert blue - red > 40
