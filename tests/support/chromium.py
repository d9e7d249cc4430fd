"""A viewer in a real browser: Chromium without a window, with a page that answers what it is offered."""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aioice.ice
from openrois_signaling.messages import IceServer, Offer
from openrois_streaming.errors import SessionError
from openrois_streaming.testing import ImpairedPath
from playwright.async_api import Browser, Page, async_playwright

from tests.support.loopback import PATIENCE, Engine

# Offers come in through `respond`; a candidate goes out through `trickle`. What plays is in `media`, by mid.
_PAGE = """
window.peers = {}; window.media = {}; window.frames = {}; window.closed = [];
window.respond = async (offer, bend) => {
  let pc = peers[offer.peer_id];
  if (!pc) {
    pc = peers[offer.peer_id] = new RTCPeerConnection(window.configuration);
    pc.onicecandidate = e => trickle(offer.peer_id, e.candidate ? e.candidate.toJSON() : null);
    pc.ontrack = e => {
      const element = document.createElement(e.track.kind);
      element.muted = true; element.autoplay = true; element.srcObject = new MediaStream([e.track]);
      document.body.append(element);
      media[e.transceiver.mid] = element;
      if (e.track.kind === 'video') {
        const count = () => { frames[e.transceiver.mid] = (frames[e.transceiver.mid] || 0) + 1;
                              element.requestVideoFrameCallback(count); };
        element.requestVideoFrameCallback(count);
      } else {
        const context = window.audio = window.audio || new AudioContext();
        const analyser = context.createAnalyser();
        context.createMediaStreamSource(element.srcObject).connect(analyser);
        const samples = new Float32Array(analyser.fftSize);
        window.loudest = window.loudest || {};
        setInterval(() => { analyser.getFloatTimeDomainData(samples);
          loudest[e.transceiver.mid] = Math.max(loudest[e.transceiver.mid] || 0, ...samples.map(Math.abs)); }, 20);
      }
    };
  }
  await pc.setRemoteDescription({type: 'offer', sdp: offer.sdp});
  if (bend) (new Function('pc', bend))(pc);
  const answer = await pc.createAnswer();
  await pc.setLocalDescription(answer);
  return answer.sdp;
};
"""


class Tab:
    """A page of Chromium as an application of `engine`. `bend` is JavaScript that runs before it answers."""

    def __init__(self, engine: Engine, page: Page) -> None:
        self.engine = engine
        self.page = page
        self.bend = ""
        self.candidates: list[str] = []
        self.pass_offered_candidates = True
        self.path: ImpairedPath | None = None
        """What its media passes; None for nothing."""
        self.refusals: list[SessionError] = []
        self._newest: dict[str, Offer] = {}

    async def open(self) -> None:
        await self.page.goto("about:blank")
        await self.page.expose_function("trickle", self._trickle)
        await self.page.evaluate("() => {" + _PAGE + "}")
        self.engine.application = self.respond

    async def configure(self, *servers: IceServer, relay_only: bool = False) -> None:
        """Have the peer connections that are opened from now on use these servers."""
        policy = "relay" if relay_only else "all"
        told = {"iceServers": [server.wire() for server in servers], "iceTransportPolicy": policy}
        await self.page.evaluate("told => { window.configuration = told; }", told)

    async def respond(self, offer: Offer) -> None:
        self._newest[offer.peer_id] = offer
        wire = offer.wire()
        if not self.pass_offered_candidates:
            wire["sdp"] = "".join(
                line for line in offer.sdp.splitlines(keepends=True) if not line.startswith("a=candidate")
            )
        if self.path is not None:
            wire["sdp"] = self.path.to_viewer(wire["sdp"])
        sdp = await self.page.evaluate("([offer, bend]) => respond(offer, bend)", [wire, self.bend])
        if self.path is not None:
            sdp = self.path.to_engine(sdp)
        try:
            await self.engine.answer(offer, sdp)
        except SessionError as refusal:
            self.refusals.append(refusal)

    async def _trickle(self, peer_id: str, candidate: dict[str, Any] | None) -> None:
        if candidate is None or not candidate["candidate"]:
            return
        self.candidates.append(candidate["candidate"])
        if self.path is not None:
            candidate["candidate"] = self.path.to_engine(candidate["candidate"])
        try:
            await self.engine.candidate(self._newest[peer_id], candidate["candidate"], candidate["sdpMid"])
        except SessionError as refusal:
            self.refusals.append(refusal)

    async def plays(self, mid: str = "0", frames: int = 3) -> None:
        """Wait for so many more presented frames of a video section."""
        await self.page.wait_for_function(
            "([mid, goal]) => (frames[mid] || 0) >= goal",
            arg=[mid, await self.frames(mid) + frames],
            timeout=PATIENCE * 1000,
        )

    async def frames(self, mid: str = "0") -> int:
        """Frames presented so far."""
        return int(await self.page.evaluate("mid => frames[mid] || 0", mid))

    async def hears(self, mid: str, loudness: float = 0.05) -> None:
        """Wait for a sound of an audio section that was at least so loud (1 is full scale)."""
        await self.page.wait_for_function(
            "([mid, goal]) => (window.loudest || {})[mid] >= goal", arg=[mid, loudness], timeout=PATIENCE * 1000
        )


@asynccontextmanager
async def browser_at(program: Path, *, hide_addresses: bool = True) -> AsyncIterator[Browser]:
    """A browser, as a person has it; it may be set not to hide its addresses behind `.local` names."""
    arguments: Sequence[str] = ["--no-sandbox", "--autoplay-policy=no-user-gesture-required"]
    if not hide_addresses:
        arguments = [*arguments, "--disable-features=WebRtcHideLocalIpsWithMdns"]
    if aioice.ice.get_host_addresses(use_ipv4=True, use_ipv6=True) in ([], ["127.0.0.1"]):
        arguments = [*arguments, "--allow-loopback-in-peer-connection"]
    async with async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=program, args=list(arguments))
        try:
            yield browser
        finally:
            await browser.close()


@asynccontextmanager
async def tab(engine: Engine, browser: Browser) -> AsyncIterator[Tab]:
    """A page of `browser` that plays what `engine` offers."""
    page = await browser.new_page()
    try:
        one = Tab(engine, page)
        await one.open()
        yield one
    finally:
        engine.application = None
        if not page.is_closed():
            await page.close()
