"""The page of ten lines in the README of the web demo is complete: it shows the avatar and lets it speak."""

import re
import shutil
from pathlib import Path

import pytest
from aiohttp import web
from openrois_web_demo import static_files
from playwright.async_api import Browser

from tests.support.demo import Demo

pytestmark = [
    pytest.mark.browser,
    pytest.mark.engine,
    pytest.mark.asyncio(loop_scope="session"),
]

ENGINE = "puppet"

README = Path(__file__).parents[2] / "web_demo" / "README.md"
_PLAYS = "() => document.querySelector('video').getVideoPlaybackQuality().totalVideoFrames >= 30"


async def test_readme_page_shows_the_avatar_and_lets_it_speak(browser: Browser, avatar: Demo, tmp_path: Path) -> None:
    found = re.search(r"```html\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    lines = found[1].replace(":8765/", f":{avatar.port}/")
    assert lines != found[1]
    (tmp_path / "page.html").write_text(lines.replace("</script>", "document.title = 'spoken';</script>"))
    shutil.copy(str(static_files() / "openrois.js"), tmp_path)
    app = web.Application()
    app.router.add_static("/", tmp_path)
    runner = web.AppRunner(app)
    await runner.setup()
    page = await browser.new_page()
    failures: list[str] = []
    page.on("pageerror", lambda error: failures.append(str(error)))
    try:
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        await page.goto(f"http://127.0.0.1:{runner.addresses[0][1]}/page.html")
        await page.wait_for_function(_PLAYS)
        await page.wait_for_function("() => document.title === 'spoken'")
    finally:
        await page.close()
        await runner.cleanup()
    assert failures == []
