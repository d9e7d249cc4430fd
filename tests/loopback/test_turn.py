"""Media over a TURN server with short-lived credentials: coturn, on this machine."""

import re
import time
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from openrois_demo.doctor import network
from openrois_signaling.messages import Candidate, IceServer
from openrois_streaming.network.servers import read_servers
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.state import StreamStatus

from tests.support import loopback
from tests.support.chromium import browser_at, tab
from tests.support.loopback import Engine
from tests.support.turn import Turn, coturn

pytestmark = [pytest.mark.media, pytest.mark.usefixtures("turnserver")]

RELAY = NetworkSettings(relay_only=True)
LOOPBACK = NetworkSettings(interfaces=("127.0.0.1",))


@pytest.fixture
async def turn(tmp_path: Path) -> AsyncIterator[Turn]:
    async with coturn(tmp_path) as turn:
        yield turn


def paths(engine: Engine) -> set[str]:
    """The types of the engine's candidates in the newest offer."""
    named = [line.split() for line in engine.offers[-1].sdp.splitlines() if line.startswith("a=candidate:")]
    return {words[7] for words in named}


@pytest.mark.parametrize("transport", ["udp", "tcp"])
async def test_media_passes_over_the_relay_alone(turn: Turn, transport: str) -> None:
    server = turn.server(time.time() + 60, transport=transport)
    async with loopback.engine(network=RELAY, ice_servers=[server]) as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays(frames=20)
        assert paths(engine) == {"relay"}
        assert "raddr 0.0.0.0 rport 9" in engine.offers[0].sdp, "the engine's address is hidden"
        assert engine.session.guarded.strangers == 0


@pytest.mark.parametrize(("secret", "lifetime"), [("another secret altogether", 60), (None, -1)])
async def test_a_wrong_or_old_credential_ends_it_with_a_reason(turn: Turn, secret: str | None, lifetime: int) -> None:
    server = turn.server(time.time() + lifetime, secret=secret)
    async with loopback.engine(network=RELAY, ice_servers=[server]) as engine:
        engine.connect("v", "video")
        await engine.until("v", StreamStatus.NOT_CONNECTED)
        assert [bye.reason for bye in engine.byes] == [
            "the engine is set to relays only and got none: the TURN server refuses the credentials"
        ]
        assert engine.offers == []


async def test_a_second_server_is_used_where_the_first_is_not_there(turn: Turn) -> None:
    gone = IceServer(urls=("turn:127.0.0.1:1?transport=tcp",), username="u", credential="c")
    servers = [gone, turn.server(time.time() + 60)]
    async with loopback.engine(network=RELAY, ice_servers=servers) as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays()


async def test_a_relay_follows_the_offer_and_is_used_where_nothing_else_works(turn: Turn) -> None:
    server = turn.server(time.time() + 60)
    async with loopback.engine(network=LOOPBACK, ice_servers=[server]) as engine, loopback.viewer(engine) as viewer:

        async def take(candidate: Candidate) -> None:
            await viewer.take(candidate)

        engine.trickled = take
        # The viewer is told of no address of the engine but the relay's. The engine knows the viewer's address, or the
        # relay would let nothing of it pass, but no port where it listens.
        viewer.bend_offer = lambda sdp: loopback.without(sdp, "a=candidate:")
        viewer.bend_answer = lambda sdp: re.sub(r"(a=candidate:(?:\S+ ){5})\d+", r"\g<1>1025", sdp)
        engine.connect("v", "video")
        await viewer.plays(frames=20)
        assert paths(engine) == {"host"}
        assert [candidate.candidate is None or "typ relay" in candidate.candidate for candidate in engine.candidates]


async def test_a_server_that_dies_ends_the_peer_connection_with_a_reason(turn: Turn) -> None:
    server = turn.server(time.time() + 60)
    async with (
        loopback.engine(network=RELAY, ice_servers=[server], speed=4) as engine,
        loopback.viewer(engine) as viewer,
    ):
        engine.connect("v", "video")
        await viewer.plays()
        turn.process.kill()
        await engine.until("v", StreamStatus.NOT_CONNECTED)
        assert [bye.reason for bye in engine.byes] == ["the viewer is gone"]


@pytest.mark.browser
@pytest.mark.long
async def test_a_browser_and_the_engine_meet_at_their_relays(turn: Turn, chromium: Path) -> None:
    servers = [turn.server(time.time() + 60)]
    async with (
        loopback.engine(network=RELAY, ice_servers=servers) as engine,
        browser_at(chromium) as browser,
        tab(engine, browser) as page,
    ):
        await page.configure(turn.server(time.time() + 60), relay_only=True)
        engine.connect("v", "video")
        await page.plays()
        assert page.candidates
        assert all(" typ relay " in candidate for candidate in page.candidates)


async def test_it_can_be_tried_without_a_stream(turn: Turn) -> None:
    for lifetime, level, words in ((60, "ok", "relays at 127.0.0.1:"), (-1, "fail", "refuses the credentials")):
        (finding,) = await network.servers(read_servers([turn.server(time.time() + lifetime)]))
        assert finding.level == level
        assert words in finding.detail
    (seen,) = await network.servers(read_servers([IceServer(urls=(f"stun:127.0.0.1:{turn.port}",))]))
    assert "sees this machine at 127.0.0.1:" in seen.detail
