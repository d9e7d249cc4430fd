import asyncio
import os
import stat
from pathlib import Path

import pytest
from openrois_bench.errors import BenchFailed
from openrois_bench.viewing.browser import chromium_version, watch_in_chromium
from openrois_bench.viewing.observation import Order, Sightings

ORDER = Order(
    url="ws://127.0.0.1:1/", component_ref="bench/video_streaming", codec="video/H264", seconds=1, runs=2, resumes=2
)
SIGHTINGS = Sightings(
    width=640, height=360, numbers=(1, 2), unreadable=0, milliseconds={"presented": (30.5, 31.0), "connect": (80.0,)}
)


def program(folder: Path, name: str, text: str) -> str:
    """A shell script that stands in for a browser."""
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


async def test_version_is_the_browsers_number(tmp_path: Path) -> None:
    assert await chromium_version(program(tmp_path, "b", "echo Chromium 156.0.1 built on Debian 12; echo 7 >&2")) == (
        "156.0.1"
    )
    with pytest.raises(BenchFailed, match="does not say which version"):
        await chromium_version(program(tmp_path, "silent", "exit 1"))


BROWSER = """
for last; do :; done
{python} - "$last" <<'END'
import sys, urllib.request
from urllib.parse import parse_qs, urlsplit
address = urlsplit(sys.argv[1])
page = urllib.request.urlopen(sys.argv[1]).read().decode()
assert "requestVideoFrameCallback" in page
assert parse_qs(address.query)["order"] == [{order!r}]
urllib.request.urlopen(f"http://{{address.netloc}}/seen", data={seen!r})
END
{then}
"""


def browser(folder: Path, seen: str, then: str = "exec sleep 100") -> str:
    """A program that loads the page as a browser does and posts what it would have seen."""
    text = BROWSER.format(python="python3", order=ORDER.model_dump_json(), seen=seen.encode(), then=then)
    return program(folder, "browser", text)


@pytest.mark.engine
async def test_the_page_is_loaded_with_its_order_and_what_it_posts_is_read(tmp_path: Path) -> None:
    path = browser(tmp_path, SIGHTINGS.model_dump_json())
    async with asyncio.timeout(60):
        assert await watch_in_chromium(path, ORDER, patience=15) == SIGHTINGS


@pytest.mark.engine
@pytest.mark.parametrize(
    ("seen", "reason"),
    [
        ('{"error": "Error: an offer did not come"}', "the page in Chromium: Error: an offer did not come"),
        ('{"width": 640}', "cannot be read"),
        ("[]", "cannot be read"),
    ],
)
async def test_a_page_that_saw_nothing_says_why(tmp_path: Path, seen: str, reason: str) -> None:
    async with asyncio.timeout(60):
        with pytest.raises(BenchFailed, match=reason):
            await watch_in_chromium(browser(tmp_path, seen), ORDER, patience=15)


@pytest.mark.engine
async def test_a_browser_that_ends_has_shown_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    path = program(tmp_path, "broken", "echo no display; exit 1")
    async with asyncio.timeout(60):
        with pytest.raises(BenchFailed, match=r"Chromium ended: .*no display"):
            await watch_in_chromium(path, ORDER, patience=15)
    assert await asyncio.to_thread(os.listdir, tmp_path) == ["broken"]


@pytest.mark.engine
async def test_a_browser_that_shows_nothing_is_ended(tmp_path: Path) -> None:
    path = program(tmp_path, "idle", "exec sleep 100")
    async with asyncio.timeout(60):
        with pytest.raises(BenchFailed, match="Chromium showed nothing within 0 s"):
            await watch_in_chromium(path, ORDER, patience=0.2)
