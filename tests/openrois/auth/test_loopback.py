"""What counts as this machine."""

import pytest

from openrois.auth.loopback import is_loopback


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.9.8.7", "::1"])
def test_this_machine(host: str) -> None:
    assert is_loopback(host)


@pytest.mark.parametrize(
    "host", ["", "0.0.0.0", "::", "192.168.0.1", "example.org", "localhost.example.org", "127.1", "127.0.0.1.nip.io"]
)
def test_not_this_machine(host: str) -> None:
    assert not is_loopback(host)
