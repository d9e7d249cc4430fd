"""Peer connections and the network around them: strangers, servers that are not there, and viewers that move."""

import asyncio
import os
import random
import socket
from collections.abc import Callable
from contextlib import suppress
from typing import cast

import ifaddr
import pytest
from aioice import stun
from openrois_signaling.messages import Candidate, IceServer, Offer
from openrois_streaming.aiortc_internals.ice import IceAgent
from openrois_streaming.network.guard import PAIRS_LIMIT, QUEUE_LIMIT
from openrois_streaming.network.interfaces import ADDRESSES_LIMIT
from openrois_streaming.network.settings import NetworkSettings, PortRange
from openrois_streaming.state import StreamStatus

from tests.support import loopback
from tests.support.loopback import Engine, Viewer

pytestmark = pytest.mark.media

LOOPBACK = NetworkSettings(interfaces=("127.0.0.1",))
HELLO = bytes.fromhex("16fefd0000000000000000002f0100002300000000000000230000fefd") + bytes(32)
HOSTILE = (
    b"",
    HELLO,
    bytes.fromhex("15fefd00000000000000010002022f"),  # a fatal alert
    b"\x80\x60" + bytes(60),  # RTP
    b"\x81\xcb\x00\x01" + bytes(4),  # RTCP BYE
    b"\x40\x00\x00\x04" + bytes(4),  # TURN channel data
    b"\x06" * 20,  # an SCTP ABORT, bare
    bytes(stun.Message(stun.Method.BINDING, stun.Class.REQUEST)),
    bytes(stun.Message(stun.Method.BINDING, stun.Class.RESPONSE, attributes={"XOR-MAPPED-ADDRESS": ("127.0.0.1", 9)})),
    b"\x00\x01\x00\x08\x21\x12\xa4\x42" + bytes(12) + b"\x00\x24\x00\x01    ",  # STUN that ends within an attribute
    b"\x00" * 1400,
)


def forged(username: str) -> bytes:
    """A connectivity check that is signed with a wrong password."""
    request = stun.Message(stun.Method.BINDING, stun.Class.REQUEST, attributes={"USERNAME": username, "PRIORITY": 1})
    request.add_message_integrity(b"wrong")
    return bytes(request)


def ports_of(offer: Offer) -> list[int]:
    """The UDP ports on 127.0.0.1 that an offer names."""
    named = [line.split() for line in offer.sdp.splitlines() if line.startswith("a=candidate:")]
    return [int(words[5]) for words in named if words[4] == "127.0.0.1"]


def ports_and_hosts(offer: Offer) -> list[tuple[str, str]]:
    """The UDP addresses and ports that an offer names."""
    named = [line.split() for line in offer.sdp.splitlines() if line.startswith("a=candidate:")]
    return [(words[4], words[5]) for words in named]


def attribute(sdp: str, name: str) -> str:
    return next(line for line in sdp.splitlines() if line.startswith(f"a={name}:")).partition(":")[2]


class Stranger:
    """Sends hostile datagrams to a port, a bounded number of them."""

    def __init__(self, offer: Offer) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._targets = [("127.0.0.1", port) for port in ports_of(offer)]
        fragment = attribute(offer.sdp, "ice-ufrag")
        self._datagrams = (*HOSTILE, forged(f"{fragment}:x"), forged("x:y"), os.urandom(200))

    def attack(self, rounds: int = 3) -> int:
        """Send everything some times; returns how many datagrams that were."""
        for _ in range(rounds):
            for datagram in self._datagrams:
                for target in self._targets:
                    with suppress(BlockingIOError):
                        self._socket.sendto(datagram, target)
        return rounds * len(self._datagrams) * len(self._targets)

    def answers(self) -> int:
        """How many datagrams came back."""
        count = 0
        with suppress(BlockingIOError):
            while True:
                self._socket.recv(2048)
                count += 1
        return count

    def close(self) -> None:
        self._socket.close()


@pytest.mark.parametrize("seed", range(3))
async def test_strangers_do_not_disturb_a_session_before_during_and_after_its_handshake(
    seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    order = random.Random(seed)
    async with loopback.engine(network=LOOPBACK) as engine, loopback.viewer(engine) as viewer:
        respond = viewer.respond
        strangers: list[Stranger] = []

        async def attacked(offer: Offer) -> None:
            strangers.append(stranger := Stranger(offer))
            stranger.attack()
            answering = asyncio.ensure_future(respond(offer))
            while "connected" not in viewer.states and not viewer.refusals:
                stranger.attack(1)
                await asyncio.sleep(order.random() / 100)
            await answering

        engine.application = attacked
        engine.connect("v", "video")
        await viewer.plays()
        (stranger,) = strangers
        stranger.attack(20)
        await viewer.plays(frames=10)
        assert viewer.states == ["connecting", "connected"]
        assert engine.byes == []
        guarded = engine.session.guarded
        assert guarded.strangers > 60
        assert guarded.malformed > 20
        assert guarded.unauthenticated > 20
        assert guarded.unasked > 20
        assert guarded.unknown > 60
        assert 0 < stranger.answers() < guarded.unauthenticated / 2, "few are worth an answer"
        stranger.close()
    assert "Traceback" not in caplog.text
    assert [record for record in caplog.records if record.levelname in ("ERROR", "WARNING")] == []


async def test_a_flood_before_the_answer_is_bounded() -> None:
    async with loopback.engine(network=LOOPBACK) as engine:
        engine.connect("v", "video")
        await engine.news.until(lambda: engine.offers)
        stranger = Stranger(engine.offers[0])
        for _ in range(20):
            stranger.attack(10)
            await asyncio.sleep(0)
        await engine.news.until(lambda: True)
        async with loopback.viewer(engine) as viewer:
            await viewer.respond(engine.offers[0])
            await viewer.plays()
        assert engine.session.guarded.overflow == 0, f"nothing of a stranger takes one of {QUEUE_LIMIT} places"
        stranger.close()


async def test_guard_drops_nothing_without_an_attack() -> None:
    for _ in range(3):
        async with loopback.engine(network=LOOPBACK) as engine, loopback.viewer(engine) as viewer:
            engine.connect("v", "video")
            engine.connect("a", "audio")
            await viewer.plays("0")
            await viewer.plays("1")
            guarded = engine.session.guarded
            assert (guarded.strangers, guarded.malformed, guarded.unknown, guarded.overflow) == (0, 0, 0, 0)
            assert (guarded.peer_limit, guarded.total_limit) == (0, 0)


async def test_ports_are_in_range_and_the_public_address_is_a_candidate() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        taken = probe.getsockname()[1]
        ports = PortRange(taken, min(taken + 20, 65535))
        network = NetworkSettings(("127.0.0.1",), ports, "198.51.100.7")
        async with loopback.engine(network=network) as engine, loopback.viewer(engine) as viewer:
            engine.connect("v", "video")
            await viewer.plays()
            (port,) = ports_of(engine.offers[0])
            assert taken < port <= ports.last
            assert f" 198.51.100.7 {port} typ srflx raddr 127.0.0.1 rport {port}" in engine.offers[0].sdp


async def test_no_free_port_is_said() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        taken = probe.getsockname()[1]
        async with loopback.engine(network=NetworkSettings(("127.0.0.1",), PortRange(taken, taken))) as engine:
            engine.connect("v", "video")
            await engine.until("v", StreamStatus.NOT_CONNECTED)
            assert [bye.reason for bye in engine.byes] == ["none of the engine's UDP ports are free: widen --udp-ports"]


@pytest.mark.parametrize(
    ("network", "servers", "reason"),
    [
        (
            NetworkSettings(interfaces=("nowhere0",)),
            (),
            "the engine lacks the network interface that --interface names",
        ),
        (
            NetworkSettings(relay_only=True),
            (),
            "the engine is set to relays only and has no TURN server: configure one",
        ),
        (
            NetworkSettings(relay_only=True),
            (IceServer(urls=("turn:127.0.0.1:1?transport=tcp",), username="u", credential="c"),),
            "the engine is set to relays only and got none: the TURN server cannot be reached",
        ),
    ],
)
async def test_without_a_way_out_a_peer_connection_ends_with_a_reason(
    network: NetworkSettings, servers: tuple[IceServer, ...], reason: str
) -> None:
    async with loopback.engine(network=network, ice_servers=servers) as engine:
        engine.connect("v", "video")
        await engine.until("v", StreamStatus.NOT_CONNECTED)
        assert [bye.reason for bye in engine.byes] == [reason]
        assert engine.offers == []


async def test_a_machine_and_an_application_with_very_many_addresses(monkeypatch: pytest.MonkeyPatch) -> None:
    many = [ifaddr.IP(f"127.0.0.{host}", 8, "many0") for host in range(1, 62)]
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [ifaddr.Adapter("many0", "many0", many, index=1)])
    lists: list[int] = []
    limit_pairs = IceAgent._sort_check_list

    def observed(agent: IceAgent) -> None:
        limit_pairs(agent)
        lists.append(len(agent.connection._check_list))

    monkeypatch.setattr(IceAgent, "_sort_check_list", observed)
    candidates = "".join(f"a=candidate:{n} 1 udp {n} 127.0.1.{n} {3000 + n} typ host\r\n" for n in range(1, 61))

    def answered(sdp: str) -> str:
        head, first = loopback.without(sdp, "a=candidate:", "a=end-of-candidates").split("m=")
        return f"{head}m={first}{candidates}"

    async with loopback.engine() as engine, loopback.viewer(engine) as viewer:
        viewer.bend_answer = answered
        engine.connect("v", "video")
        await viewer.plays()
        assert len(set(ports_and_hosts(engine.offers[0]))) == ADDRESSES_LIMIT
        assert max(lists) == PAIRS_LIMIT


class StunServer(asyncio.DatagramProtocol):
    """Says that everybody is seen at 198.51.100.9; or nothing at all."""

    def __init__(self, *, answers: bool) -> None:
        self._answers = answers
        self.asked = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        self.asked += 1
        if self._answers:
            request = stun.parse_message(data)
            seen = {"XOR-MAPPED-ADDRESS": ("198.51.100.9", addr[1])}
            response = stun.Message(stun.Method.BINDING, stun.Class.RESPONSE, request.transaction_id, seen)
            self._transport.sendto(bytes(response), addr)


async def stun_server(*, answers: bool) -> tuple[asyncio.DatagramTransport, StunServer, IceServer]:
    transport, server = await asyncio.get_running_loop().create_datagram_endpoint(
        lambda: StunServer(answers=answers), local_addr=("127.0.0.1", 0)
    )
    return transport, server, IceServer(urls=(f"stun:127.0.0.1:{transport.get_extra_info('sockname')[1]}",))


async def test_a_server_that_does_not_answer_is_not_waited_for() -> None:
    transport, server, url = await stun_server(answers=False)
    async with loopback.engine(network=LOOPBACK, ice_servers=[url]) as engine, loopback.viewer(engine) as viewer:
        engine.connect("v", "video")
        await viewer.plays()
        assert engine.candidates == [], "it plays long before the server is given up"
        assert "end-of-candidates" not in engine.offers[0].sdp
        await engine.news.until(lambda: server.asked)
    transport.close()


async def test_server_candidates_follow_the_offer() -> None:
    transport, _, url = await stun_server(answers=True)
    async with loopback.engine(network=LOOPBACK, ice_servers=[url]) as engine, loopback.viewer(engine) as viewer:
        told: list[Candidate] = []

        async def remember(candidate: Candidate) -> None:
            told.append(candidate)

        engine.trickled = remember
        engine.connect("v", "video")
        await viewer.plays()
        await engine.news.until(lambda: len(told) == 2)
        found, last = told
        (port,) = ports_of(engine.offers[0])
        assert found.candidate is not None
        assert f" 198.51.100.9 {port} typ srflx raddr 127.0.0.1 rport {port}" in found.candidate
        assert (found.peer_id, found.generation, found.sdp_mid) == ("engine/p1", 1, "0")
        assert not last.candidate
        engine.connect("a", "audio")
        await viewer.plays("1")
        assert "198.51.100.9" in engine.offers[1].sdp, "a later offer has it too"
        assert "end-of-candidates" in engine.offers[1].sdp
    transport.close()


class Router(asyncio.DatagramProtocol):
    """A NAT between a viewer and the engine, that may give the viewer another port at any time."""

    def __init__(self, engine_port: int) -> None:
        self._engine = ("127.0.0.1", engine_port)
        self._viewer: tuple[str, int] | None = None
        self._outside: asyncio.DatagramTransport | None = None
        self._inside: asyncio.DatagramTransport | None = None

    async def open(self) -> int:
        """Start; returns the port by which the viewer reaches the engine."""
        self._inside, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: self, local_addr=("127.0.0.1", 0)
        )
        await self.move()
        return int(self._inside.get_extra_info("sockname")[1])

    async def move(self) -> None:
        """Appear to the engine under another port."""
        old = self._outside
        outside = _Outside(self._back)
        self._outside, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: outside, remote_addr=self._engine
        )
        if old is not None:
            old.close()

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        self._viewer = addr
        assert self._outside is not None
        self._outside.sendto(data)

    def _back(self, data: bytes) -> None:
        if self._viewer is not None and self._inside is not None:
            self._inside.sendto(data, self._viewer)

    def close(self) -> None:
        for transport in (self._inside, self._outside):
            if transport is not None:
                transport.close()


class _Outside(asyncio.DatagramProtocol):
    def __init__(self, back: Callable[[bytes], None]) -> None:
        self._back = back

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        self._back(data)

    def error_received(self, exc: Exception) -> None:
        pass


async def behind_a_router(engine: Engine, viewer: Viewer) -> Router:
    """Let the viewer reach the engine through a router, and no other way."""
    routers: list[Router] = []
    respond = viewer.respond

    async def routed(offer: Offer) -> None:
        (port,) = ports_of(offer)
        router = Router(port)
        inside = await router.open()
        routers.append(router)
        viewer.bend_offer = lambda sdp: sdp.replace(f"127.0.0.1 {port} ", f"127.0.0.1 {inside} ")
        await respond(offer)

    engine.application = routed
    viewer.bend_answer = lambda sdp: loopback.without(sdp, "a=candidate:", "a=end-of-candidates")
    engine.connect("v", "video")
    await viewer.plays()
    return routers[0]


async def test_a_viewer_whose_port_changes_plays_on(monkeypatch: pytest.MonkeyPatch) -> None:
    # The viewer is aiortc, which checks its path every 5 s; a browser does so twice a second.
    monkeypatch.setattr("aioice.ice.CONSENT_INTERVAL", 0.5)
    async with loopback.engine(network=LOOPBACK) as engine, loopback.viewer(engine) as viewer:
        router = await behind_a_router(engine, viewer)
        await viewer.plays()
        await router.move()
        await viewer.plays(frames=60)
        assert engine.byes == []
        assert len(engine.offers) == 1
        router.close()


async def test_a_path_that_died_is_replaced_under_the_same_stream_id() -> None:
    async with loopback.engine(network=LOOPBACK) as engine, loopback.viewer(engine) as viewer:
        router = await behind_a_router(engine, viewer)
        router.close()
        engine.application, viewer.bend_offer = viewer.respond, str
        engine.session.restart("engine/p1")
        await engine.news.until(lambda: engine.byes)
        assert [(bye.peer_id, bye.reason) for bye in engine.byes] == [("engine/p1", "it was replaced")]
        assert engine.offers[-1].replaces == "engine/p1"
        assert [stream.stream_id for stream in engine.offers[-1].streams] == ["v"]
        await viewer.plays()
        assert engine.statuses("v")[-1] is StreamStatus.RUNNING


async def test_a_viewer_that_does_not_come_back_is_given_up() -> None:
    async with loopback.engine(network=LOOPBACK, speed=4) as engine, loopback.viewer(engine) as viewer:
        router = await behind_a_router(engine, viewer)
        router.close()
        await engine.until("v", StreamStatus.NOT_CONNECTED)
        assert [bye.reason for bye in engine.byes] == ["the viewer is gone"]
