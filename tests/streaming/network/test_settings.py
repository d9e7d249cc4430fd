from typing import Any

import pytest
from openrois_streaming.network.settings import NetworkSettings, PortRange


@pytest.mark.parametrize(("text", "ports"), [("50000-50100", PortRange(50000, 50100)), ("5000", PortRange(5000, 5000))])
def test_a_range_is_read(text: str, ports: PortRange) -> None:
    assert PortRange.parse(text) == ports


@pytest.mark.parametrize("text", ["", "-", "1-", "-1", "a-b", "1-2-3", "1 - 2", "\u0661-2", "123456"])
def test_malformed_port_range_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is not a range of UDP ports"):
        PortRange.parse(text)


def test_the_defaults_are_for_a_local_network() -> None:
    assert NetworkSettings().policy.permits("192.168.1.1")
    assert not NetworkSettings(candidates="public").policy.permits("192.168.1.1")


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"candidates": "wan"}, "use one of lan, public"),
        ({"interfaces": ("",)}, "interface"),
        ({"interfaces": ("eth0\n",)}, "interface"),
        ({"ports": PortRange(50100, 50000)}, "smaller one first"),
        ({"ports": PortRange(80, 90)}, "from 1024"),
        ({"ports": PortRange(60000, 70000)}, "to 65535"),
        ({"public_address": "example.org"}, "not an IPv4 address"),
        ({"public_address": "::1"}, "not an IPv4 address"),
        ({"public_address": "127.0.0.1"}, "cannot be reached"),
        ({"public_address": "0.0.0.0"}, "cannot be reached"),
        ({"relay_only": True, "public_address": "203.0.113.1"}, "--relay-only excludes"),
        ({"relay_only": True, "ports": PortRange(5000, 5001)}, "--relay-only excludes"),
    ],
)
def test_unusable_settings_are_refused_with_reason(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        NetworkSettings(**settings)


def test_usable_settings_are_accepted() -> None:
    every = NetworkSettings(("eth0", "10.0.0.1"), PortRange(50000, 50000), "203.0.113.1", candidates="public")
    assert every.ports == (50000, 50000)
    assert NetworkSettings(relay_only=True).relay_only
