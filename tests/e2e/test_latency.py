"""The latency shown by the page, compared with stamps in the pictures, in both browsers and for all encoders."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from openrois_avatar.link.address import ADDRESS_VARIABLE
from playwright.async_api import Browser

from tests.support.browser import Visit, visiting
from tests.support.demo import Demo, end, running_demo
from tests.support.firefox import FirefoxTab, firefox_at

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

_STAMPED = "probe.frames.filter(({ time, rtp }) => time !== null && rtp !== undefined)"
_APART = f"""(() => {{
    const frames = {_STAMPED}.slice(-90);
    const told = frames.filter(({{ rtp }}) => openrois.video?.capturedAt(rtp) != null);
    if (told.length < 60) return null;
    return probe.median(told.map(({{ time, rtp }}) => probe.since(time, openrois.video.capturedAt(rtp))));
}})()"""
"""Milliseconds by which the capture time of a picture's RTP timestamp is later than its stamp; null before it is known.
It is a median, because a browser that calls back for a picture may show the next one by then."""
_SHOWN = "Number(document.querySelector('[data-testid=figure-latency]').dataset.value || NaN)"
_MEASURED = f"""probe.median({_STAMPED}
    .filter(({{ at }}) => performance.now() - at < 2000)
    .map(({{ time, visible }}) => probe.since(time, performance.timeOrigin + visible)))"""
"""Milliseconds from the stamp's time until the page takes a picture to be visible, in the last two seconds."""

CLOSE = 5
"""Milliseconds by which the two may differ."""


@pytest.fixture
def encoding(tmp_path: Path) -> Iterator[Demo]:
    """A demo whose engine encodes and stamps its pictures itself."""
    address = f"unix:{tmp_path / 'engine'}"
    with running_demo(tmp_path, "external", ("--link", address)) as demo:
        command = (sys.executable, "-m", "tests.support.encoding_engine")
        engine = subprocess.Popen(command, env={**os.environ, ADDRESS_VARIABLE: address}, text=True)
        try:
            yield demo
        finally:
            end(engine)


async def _agree(page: Visit | FirefoxTab) -> None:
    await page.until(f"{_APART} !== null")
    assert abs(await page.read(_APART)) < CLOSE
    # It is told once a second: while a machine becomes busy the one is a little older than the other.
    await page.until(f"Math.abs({_SHOWN} - {_MEASURED}) <= {CLOSE}")


async def test_the_latency_that_is_shown_is_that_of_a_stamp(visit: Visit) -> None:
    await _agree(visit)


@pytest.mark.long
async def test_firefox_shows_it_too(firefox_program: Path, demo: Demo, tmp_path: Path) -> None:
    async with firefox_at(firefox_program, tmp_path, demo.page) as firefox:
        await _agree(firefox)
        assert firefox.complaints == []


@pytest.mark.long
async def test_pictures_that_an_engine_has_encoded_itself_have_it_too(browser: Browser, encoding: Demo) -> None:
    async with visiting(browser, encoding.page) as visit:
        await _agree(visit)
