"""The address of a daemon."""

import pytest
from openrois_robots.reachy.daemon.address import PORT, Address, read_address

pytestmark = pytest.mark.extra(name="reachy")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("192.168.1.20", Address("192.168.1.20", PORT)),
        ("reachy-mini.local:18000", Address("reachy-mini.local", 18000)),
        ("[fe80::1%eth0]:9", Address("fe80::1%eth0", 9)),
    ],
)
def test_an_address_is_read(text: str, expected: Address) -> None:
    assert read_address(text) == expected


def test_an_address_is_a_url() -> None:
    assert Address("::1").url("http") == "http://[::1]:8000"


def test_what_is_no_address_is_said_with_an_example() -> None:
    with pytest.raises(ValueError, match="no address of a robot: expected HOST or HOST:PORT, such as"):
        read_address("not an address")
