import ifaddr
import pytest
from openrois_streaming.network.interfaces import NoInterface, host_addresses

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
def test_one_that_is_not_there_is_said() -> None:
    with pytest.raises(NoInterface, match="wlan0; there are: docker0, eth0, lo"):
        host_addresses(("wlan0",))


def test_loopback_is_used_where_there_is_nothing_else(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ifaddr, "get_adapters", lambda: [LOOPBACK])
    assert host_addresses() == ["127.0.0.1"]
