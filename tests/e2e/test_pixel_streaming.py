"""Epic's own front-end of Pixel Streaming shows the avatar and operates it; nothing in it was changed."""

import asyncio
import os
import shutil
import subprocess
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio
from openrois_avatar.adapter import serve_scene
from openrois_avatar.options.pixel_streaming import PixelStreaming
from openrois_avatar.scene import Scene, embedded_scene
from openrois_streaming.clock import SystemClock
from playwright.async_api import Browser

from tests.support.browser import PATIENCE, Visit, visiting
from tests.support.pixel_signaling import PixelSignaling, pixel_signaling

pytestmark = [pytest.mark.browser, pytest.mark.timeout(60), pytest.mark.asyncio(loop_scope="session")]

HERE = Path(__file__).parent / "pixel_streaming"
ESBUILD = Path(__file__).parents[2] / "web_demo" / "node_modules" / ".bin" / "esbuild"
PAGE = b"""<!doctype html><title>Pixel Streaming</title><link rel=icon href=data:,>
<style>body { margin: 0 } h1 { display: none } #place { width: 640px; height: 360px }</style>
<h1>OpenRoIS</h1><div id=place><div id=stage></div></div><script src=page.js></script>"""


PAD = """(() => {
  const buttons = Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0}));
  window.pad = {id: "pad", index: 0, connected: true, mapping: "standard", axes: [0, 1, 0, 0], buttons};
  navigator.getGamepads = () => [pad];
  dispatchEvent(Object.assign(new Event("gamepadconnected"), {gamepad: pad}));
})()"""
"""A gamepad whose left stick is pulled back."""


@pytest.fixture(scope="module")
def front_end(node: Path, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The script of a page with Epic's front-end in it; what it needs is installed for this test alone."""
    if not (HERE / "node_modules" / ".package-lock.json").is_file():
        npm = shutil.which("npm")
        assert npm is not None
        command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"]
        installed = subprocess.run(command, cwd=HERE, check=False).returncode == 0
        if not installed and os.environ.get("OPENROIS_REQUIRE_ALL") != "1":
            pytest.skip("Epic's front-end cannot be installed: npm needs a network for it, once")
        assert installed, "npm could not install Epic's front-end"
    bundle = tmp_path_factory.mktemp("pixel") / "page.js"
    subprocess.run([ESBUILD, "page.js", "--bundle", f"--outfile={bundle}", "--log-level=error"], cwd=HERE, check=True)
    return bundle.read_bytes()


class Scenery:
    """An avatar at a signaling server, and a visit to the page of Epic's front-end."""

    def __init__(self, visit: Visit, signaling: PixelSignaling, scene: Scene) -> None:
        self.visit = visit
        self.signaling = signaling
        self.scene = scene

    async def told(self, name: str, so: str = "true") -> Any:
        """Wait for an event of the front-end that fits."""
        return await self.visit.until(f"told.findLast(({{name, data}}) => name === '{name}' && ({so}))")

    async def walks(self, key: str = "", ahead: float = 1.0) -> None:
        """Wait until the figure has gone a step ahead, or back; a key that is held repeats, as keyboards do it."""
        begun = self.scene.place()
        assert begun is not None
        async with asyncio.timeout(PATIENCE):
            while (place := self.scene.place()) is None or (begun.y - place.y) * ahead < 0.2:
                await (self.visit.page.keyboard.down(key) if key else self.visit.read("0"))
        if key:
            await self.visit.page.keyboard.up(key)


@pytest_asyncio.fixture(loop_scope="session")
async def scenery(browser: Browser, front_end: bytes) -> AsyncIterator[Scenery]:
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        signaling = await stack.enter_async_context(pixel_signaling())
        scene = await stack.enter_async_context(
            embedded_scene("avatar", "openrois_avatar.engines.puppet", clock, arguments=("--size", "640x360"))
        )
        streamer = PixelStreaming(f"{signaling.url}/streamer", "avatar", input=True)
        await stack.enter_async_context(serve_scene("avatar", scene, clock, streamer=streamer))
        await signaling.until_heard("endpointId")
        signaling.pages = {"/": ("text/html", PAGE), "/page.js": ("text/javascript", front_end)}
        visit = await stack.enter_async_context(visiting(browser, signaling.url.replace("ws", "http")))
        yield Scenery(visit, signaling, scene)


@pytest.mark.long
async def test_it_shows_the_avatar_and_operates_it_and_comes_back_when_the_signaling_server_was_gone(
    scenery: Scenery,
) -> None:
    visit = scenery.visit
    await visit.plays(10)
    await visit.until("new Set(probe.frames.map(({ rtp }) => rtp)).size > 10")
    await visit.until("player._inputController && !player._webRtcController.isQualityController")
    await scenery.told("initialSettings")
    await scenery.walks("ArrowUp")
    await visit.read(PAD)
    await scenery.walks(ahead=-1.0)
    await visit.read("(pad.axes = [0, 0, 0, 0], navigator.getGamepads = () => [])")

    # The pointer hovers, as the streamer wants it: it is not locked, and the avatar looks at it.
    assert await visit.read("player.config.isFlagEnabled('HoveringMouse')")
    await visit.page.mouse.move(600, 40)
    await visit.read("player.requestLatencyTest()")
    await scenery.told("latencyTestResult", "data.latencyTimings.ReceiptTimeMs > 0")
    before = await visit.read("player._webRtcController.peerConnectionController.peerConnection.connectionState")
    assert before == "connected"
    if shot := os.environ.get("OPENROIS_SHOT"):
        await visit.page.screenshot(path=shot)

    await visit.read("player._inputController = false")
    await scenery.signaling.streamers["avatar"].close()
    await scenery.told("webRtcDisconnected")
    await scenery.signaling.until_heard("endpointId", 2)
    await scenery.signaling.until_heard("offer", 2)
    await visit.plays(10)
    await visit.until("player._inputController")
    await scenery.walks("ArrowUp")
