"""Every way in which the page can fail has a sentence of its own, and nothing stands in the console."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Browser, expect

from openrois.gateway.server import Gateway
from tests.support.accessibility import found_by_axe
from tests.support.browser import GATEWAY_AWAY, running_browser, visiting
from tests.support.premises import running_avatar, running_gateway

pytestmark = [pytest.mark.browser, pytest.mark.asyncio(loop_scope="session")]

_ONLY_UNKNOWN_CODECS = """
    const codecs = [{ mimeType: "video/future", clockRate: 90000, sdpFmtpLine: "" }];
    RTCRtpReceiver.getCapabilities = () => ({ codecs, headerExtensions: [] });
"""
_NO_WEBRTC = "delete globalThis.RTCPeerConnection; delete globalThis.RTCRtpReceiver;"
_IMPATIENT = "const now = performance.now.bind(performance); performance.now = () => 5 * now();"
"""A page to which a second is as long as five."""
_ENABLED = """[...document.querySelectorAll("main :is(button, input, select):enabled")]
    .filter((each) => each.checkVisibility()).map(({ dataset }) => dataset.testid)"""
"""What of the page can be used now."""
_POLICY = ("webrtc-ip-handling-policy", "force-webrtc-ip-handling-policy")


@pytest_asyncio.fixture(loop_scope="session")
async def gateway() -> AsyncIterator[Gateway]:
    async with running_gateway() as gateway:
        yield gateway


async def test_banner_names_a_lost_gateway(browser: Browser) -> None:
    async with AsyncExitStack() as stack:
        async with running_gateway() as gateway:
            phone = {"width": 360, "height": 640}
            visit = await stack.enter_async_context(
                visiting(browser, gateway.url, tolerated=[GATEWAY_AWAY], viewport=phone)
            )
            await visit.banner("no-adapter", "No avatar or robot is connected")
            await visit.page.evaluate("scrollTo(0, document.body.scrollHeight)")
        words = await visit.banner("no-gateway", "The gateway does not answer")
        assert "openrois demo" in words
        await expect(visit.item("banner")).to_be_in_viewport(ratio=1)


@pytest.mark.usefixtures("node")
@pytest.mark.long
async def test_banner_names_a_missing_avatar_until_it_connects(browser: Browser, gateway: Gateway) -> None:
    async with visiting(browser, gateway.url) as visit:
        words = await visit.banner("no-adapter", "No avatar or robot is connected")
        assert "openrois avatar" in words
        assert (await visit.look()).black
        async with running_avatar(gateway):
            await visit.plays(1)
            await visit.shows()
            await visit.no_banner()
            await expect(visit.item("video-suspend")).to_be_enabled()
        await visit.banner("adapter-gone", "has left")
        # STOP stays where it is; of all that needs the avatar nothing can be pressed.
        await expect(visit.item("stop-all")).to_be_visible()
        await expect(visit.item("stop-all")).to_be_disabled()
        usable = {"sound-on", "sound-off", "statistics-toggle", "captions-toggle", "fullscreen", "map-open"}
        assert await found_by_axe(visit.page) == []
        # What a visitor consents to can be changed at any time.
        enabled = {each for each in await visit.read(_ENABLED) if not each.startswith("consent-")}
        assert enabled <= usable | {"log-filter", "log-pause", "log-clear"}


async def test_banner_names_a_missing_codec(browser: Browser, gateway: Gateway) -> None:
    async with running_avatar(gateway), visiting(browser, gateway.url, script=_ONLY_UNKNOWN_CODECS) as visit:
        words = await visit.banner("no-codec", "decodes neither H.264 nor VP8")
        assert "Install the browser's media codecs" in words


async def test_banner_names_a_browser_without_webrtc(browser: Browser, gateway: Gateway) -> None:
    async with running_avatar(gateway), visiting(browser, gateway.url, script=_NO_WEBRTC) as visit:
        await visit.banner("no-webrtc", "This browser has no WebRTC")


@pytest.mark.long
async def test_banner_names_a_blocked_media_path(chromium: Path, gateway: Gateway) -> None:
    # This policy is for those who let nothing out but through a proxy: no UDP at all. Its switch has had two names.
    policy = [f"--{name}=disable_non_proxied_udp" for name in _POLICY]
    async with (
        running_avatar(gateway),
        running_browser(chromium, *policy) as browser,
        visiting(browser, gateway.url, script=_IMPATIENT) as visit,
    ):
        words = await visit.banner("no-media", "The picture does not get through")
        assert "firewall or VPN" in words
