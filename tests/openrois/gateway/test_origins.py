"""Which pages may connect: origins compared whole."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.gateway.origins import Origin, OriginRules, parse_origin

HOST = "gateway.example.org:8765"
RULES = OriginRules(
    origins=frozenset({Origin("https", "app.example.org", 443), Origin("http", "app.example.org", 8080)}),
    hosts=frozenset({"gateway.example.org"}),
    local=False,
    scheme="https",
)
HERE = OriginRules(RULES.origins, frozenset(), local=True, scheme="http")

ADMITTED = [
    "https://app.example.org",
    "https://app.example.org:443",
    "http://app.example.org:8080",
    "https://gateway.example.org:8765",
]
REFUSED = [
    "null",
    "",
    "*",
    "https://",
    "https://evil.example",
    "https://evil-app.example.org",
    "https://app.example.org.evil.example",
    "https://app.example.orgevil.example",
    "https://sub.app.example.org",
    "https://example.org",
    "https://app-example.org",
    "https://appxexample.org",
    "http://app.example.org",
    "https://app.example.org:8080",
    "https://app.example.org:80",
    "http://app.example.org:443",
    "https://app.example.org/",
    "https://app.example.org/path",
    "https://app.example.org?x",
    "https://app.example.org#x",
    "https://user@app.example.org",
    "https://app.example.org@evil.example",
    "https://evil.example\\@app.example.org",
    "https://app.example.org.",
    "https://APP.example.org",
    "HTTPS://app.example.org",
    "https://app.example.org https://evil.example",
    " https://app.example.org",
    "https://app.example.org\n",
    "https://app.example.org:",
    "https://app.example.org:0",
    "https://app.example.org:65979",
    "https://app.example.org:٤٤٣",
    "https://\u0430pp.example.org",
    "wss://app.example.org",
    "file://",
    "chrome-extension://abcdef",
    "http://localhost",
    "http://localhost:8765",
    "https://127.0.0.1",
    "http://gateway.example.org:8765",
    "https://gateway.example.org",
    "https://gateway.example.org:8766",
]


@pytest.mark.parametrize("origin", ADMITTED)
def test_pages_of_allowed_origins_connect(origin: str) -> None:
    assert RULES.admits(origin, HOST)


@pytest.mark.parametrize("origin", REFUSED)
def test_pages_of_other_origins_are_refused(origin: str) -> None:
    assert not RULES.admits(origin, HOST)


def test_pages_of_this_machine_where_no_token_is_needed() -> None:
    for origin in ("http://localhost", "http://127.0.0.1:5173", "https://localhost:8443", "http://[::1]:80"):
        assert HERE.admits(origin, "localhost:8765")
        assert not RULES.admits(origin, HOST)
    assert HERE.admits("https://app.example.org", "localhost:8765")
    for origin in ("null", "http://localhost.evil.example", "http://127.0.0.1.nip.io", "http://evil.example"):
        assert not HERE.admits(origin, "localhost:8765")
    # A site whose name was rebound to this machine's address.
    assert not HERE.admits("http://evil.example:8765", "evil.example:8765")


@pytest.mark.parametrize(
    ("host", "answered"),
    [
        ("gateway.example.org", True),
        ("gateway.example.org:8765", True),
        ("Gateway.Example.ORG", True),
        ("localhost:1", True),
        ("127.0.0.1", True),
        ("[::1]:8765", True),
        ("", False),
        ("evil.example", False),
        ("gateway.example.org.evil.example", False),
        ("evil-gateway.example.org", False),
        ("gateway.example.org:0", False),
        ("gateway.example.org/", False),
        ("user@gateway.example.org", False),
        ("[::1", False),
    ],
)
def test_what_the_gateway_is_called(host: str, answered: bool) -> None:
    assert RULES.answers_to(host) is answered


@given(st.sampled_from(["https://", "http://", ""]), st.text(max_size=60))
def test_any_other_text(scheme: str, text: str) -> None:
    assert not RULES.admits(scheme + text, "evil.example")


def test_what_an_origin_is() -> None:
    assert parse_origin("https://a") == Origin("https", "a", 443)
    assert parse_origin("http://[::1]:8") == Origin("http", "::1", 8)
