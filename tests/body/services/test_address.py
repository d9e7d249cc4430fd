"""Addresses of servers that are sent what is said."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.services.address import read_address


@pytest.mark.parametrize(
    ("text", "base", "destination"),
    [
        ("https://h.example", "https://h.example/v1", "https://h.example"),
        ("https://h.example/v1/", "https://h.example/v1", "https://h.example"),
        ("https://h.example:8443/api/v2", "https://h.example:8443/api/v2", "https://h.example:8443"),
        ("https://h.example/v1/audio/speech", "https://h.example/v1", "https://h.example"),
        ("http://127.0.0.1:8880/v1", "http://127.0.0.1:8880/v1", ""),
        ("http://localhost:8880", "http://localhost:8880/v1", ""),
        ("http://[::1]:8880", "http://[::1]:8880/v1", ""),
        ("https://127.0.0.1", "https://127.0.0.1/v1", ""),
    ],
)
def test_an_address_says_what_is_asked_and_where_it_goes(text: str, base: str, destination: str) -> None:
    address = read_address(text, "audio/speech")
    assert (address.base, address.destination) == (base, destination)
    assert address.url("audio/speech") == f"{base}/audio/speech"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "'' is no address of a server; write one like https://example.org/v1"),
        ("h.example/v1", "is no address"),
        ("ftp://h.example", "is no address"),
        ("https://", "is no address"),
        ("https://h.example:port", "is no address"),
        ("https://h.example/\u00e9", "is no address"),
        ("https://h.example/a b", "is no address"),
        ("https://h.example/" + "a" * 4000, "is no address"),
        ("https://key@h.example", "credentials do not belong in an address"),
        ("https://h.example/v1?key=1", "an address with [?] or # is not understood"),
        ("http://h.example/v1", "h.example is not this machine, .* allow it with --speech-unencrypted"),
        ("http://192.168.1.20:8880", "192.168.1.20 is not this machine"),
    ],
)
def test_a_mistake_is_told_with_its_remedy(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        read_address(text, "audio/speech")


def test_another_machine_without_tls_has_to_be_allowed() -> None:
    address = read_address("http://192.168.1.20:8880", "audio/speech", unencrypted=True)
    assert address.destination == "http://192.168.1.20:8880"


@given(st.text(max_size=60))
def test_whatever_is_written_is_read_or_refused(text: str) -> None:
    for lead in ("", "https://", "http://127.0.0.1"):
        with suppress(ValueError):
            assert read_address(lead + text, "audio/speech").url("a").startswith(("http://", "https://"))
