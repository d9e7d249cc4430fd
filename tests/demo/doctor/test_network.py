import socket

import pytest
from openrois_demo.doctor import network
from openrois_demo.doctor.finding import Level
from openrois_signaling.messages import IceServer
from openrois_streaming.network.servers import Servers, read_servers
from openrois_streaming.network.settings import NetworkSettings, PortRange

LOOPBACK = ("127.0.0.1",)
TURN = read_servers([IceServer(urls=("turn:127.0.0.1:1?transport=tcp",), username="u", credential="c")])


def test_loopback_alone_is_for_this_machine() -> None:
    assert network.interfaces(NetworkSettings(LOOPBACK)).level is Level.WARN


def test_an_interface_that_is_not_there_fails() -> None:
    gone = NetworkSettings(("nowhere0",))
    assert network.interfaces(gone).level is Level.FAIL
    assert network.udp_ports(gone).level is Level.FAIL
    assert network.candidates(gone, Servers()).level is Level.FAIL


def test_ports_that_are_taken_fail() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        taken = probe.getsockname()[1]
        finding = network.udp_ports(NetworkSettings(LOOPBACK, PortRange(taken, taken)))
    assert finding.level is Level.FAIL
    assert finding.detail == f"{taken}-{taken}: 0 of 1 tried are free"


def test_a_range_may_be_too_small() -> None:
    assert network.udp_ports(NetworkSettings(LOOPBACK)).level is Level.OK
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        free = probe.getsockname()[1]
    small = network.udp_ports(NetworkSettings(LOOPBACK, PortRange(free, free)))
    assert (small.level, small.detail) == (Level.WARN, f"{free}-{free}: 1 of 1 tried are free")


@pytest.mark.parametrize(
    ("settings", "servers", "level", "detail"),
    [
        (NetworkSettings(LOOPBACK), Servers(), Level.OK, "profile lan: 127.0.0.1"),
        (NetworkSettings(LOOPBACK, candidates="public"), Servers(), Level.FAIL, "none: no address here is one of the"),
        (NetworkSettings(LOOPBACK, candidates="public"), TURN, Level.OK, "profile public: relays"),
        (NetworkSettings(LOOPBACK, None, "203.0.113.1"), Servers(), Level.OK, "127.0.0.1, 203.0.113.1 (public)"),
        (NetworkSettings(relay_only=True), Servers(), Level.FAIL, "there is no TURN server"),
        (NetworkSettings(relay_only=True), TURN, Level.OK, "relays alone"),
    ],
)
def test_what_viewers_would_be_told(settings: NetworkSettings, servers: Servers, level: Level, detail: str) -> None:
    finding = network.candidates(settings, servers)
    assert finding.level is level
    assert detail in finding.detail
    assert bool(finding.advice) is (level is Level.FAIL)


async def test_servers_that_cannot_be_reached() -> None:
    unreadable = read_servers([IceServer(urls=("https://example.org",))])
    assert [finding.level for finding in await network.servers(unreadable)] == [Level.FAIL]
    (turn,) = await network.servers(TURN)
    assert (turn.level, turn.name) == (Level.FAIL, "TURN server")
    assert "cannot be reached" in turn.detail
    assert (await network.servers(Servers()))[0].level is Level.OK
