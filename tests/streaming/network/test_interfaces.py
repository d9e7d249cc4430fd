import logging

import ifaddr
import pytest
from openrois_streaming.network.interfaces import ADDRESSES_LIMIT, NoInterface, host_addresses, media_addresses

LOOPBACK = ifaddr.Adapter("lo", "lo", [ifaddr.IP("127.0.0.1", 8, "lo"), ifaddr.IP(("::1", 0, 0), 128, "lo")], index=1)
ETHERNET = ifaddr.Adapter(
    "eth0",
    "eth0",
    [
        ifaddr.IP("10.0.0.2", 24, "eth0"),
        ifaddr.IP(("fd00::2", 0, 0), 64, "eth0"),
        ifaddr.IP(("fe80::2", 0, 2), 64, "eth0"),
        ifaddr.IP(("fe80::3", 0, 0), 64, "eth0"),
    ],
    index=2,
)
BRIDGE = ifaddr.Adapter("docker0", "docker0", [ifaddr.IP("172.17.0.1", 16, "docker0")], index=3)


@pytest.fixture
def _three(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [LOOPBACK, ETHERNET, BRIDGE])


@pytest.mark.usefixtures("_three")
@pytest.mark.parametrize(
    ("interfaces", "addresses"),
    [
        ((), ["10.0.0.2", "fd00::2", "172.17.0.1"]),
        (("eth0",), ["10.0.0.2", "fd00::2"]),
        (("10.0.0.2",), ["10.0.0.2"]),
        (("172.17.0.1", "docker0"), ["172.17.0.1"]),
        (("lo",), ["127.0.0.1", "::1"]),
    ],
)
def test_interfaces_are_chosen_by_name_or_address(interfaces: tuple[str, ...], addresses: list[str]) -> None:
    assert host_addresses(interfaces) == addresses


@pytest.mark.usefixtures("_three")
def test_unknown_interface_is_refused_with_the_known_ones() -> None:
    with pytest.raises(NoInterface, match="wlan0; use one of: docker0, eth0, lo"):
        host_addresses(("wlan0",))


def test_loopback_is_used_where_there_is_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [LOOPBACK])
    assert host_addresses() == ["127.0.0.1"]


def test_of_many_addresses_media_uses_a_few_of_every_interface_and_says_so_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    many = ifaddr.Adapter("vm0", "vm0", [ifaddr.IP(f"10.1.0.{host}", 24, "vm0") for host in range(1, 62)], index=4)
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [many, ETHERNET, BRIDGE])
    assert len(host_addresses()) == 64
    with caplog.at_level(logging.WARNING):
        chosen = media_addresses()
        assert media_addresses() == chosen
    assert chosen == [
        "10.1.0.1",
        "10.0.0.2",
        "172.17.0.1",
        "10.1.0.2",
        "fd00::2",
        *(f"10.1.0.{n}" for n in range(3, 8)),
    ]
    assert len(chosen) == ADDRESSES_LIMIT
    assert caplog.messages == [
        "of 64 addresses media uses 10: 10.1.0.1, 10.0.0.2, 172.17.0.1, 10.1.0.2, fd00::2, 10.1.0.3, 10.1.0.4, "
        "10.1.0.5, 10.1.0.6, 10.1.0.7; --interface chooses others"
    ]
    assert media_addresses(("eth0",)) == ["10.0.0.2", "fd00::2"]
