"""Which requests over HTTP are looked at."""

import pytest
from openrois_agents.mcp.guard import Refused, bearer_of, host_rules

pytestmark = pytest.mark.extra(name="mcp")

RULES = host_rules("192.0.2.1", ("Tools.example.org",), ("https://App.example.org/",))


def headers(**given: str) -> list[tuple[bytes, bytes]]:
    return [(name.encode(), value.encode()) for name, value in given.items()]


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "localhost:8766", "[::1]:80", "[::1]", "192.0.2.1:80", "TOOLS.example.org", "tools.example.org:1"],
)
def test_its_own_names_are_let_in(host: str) -> None:
    RULES.check(headers(host=host))
    RULES.check(headers(host=host, origin="https://app.example.org"))


@pytest.mark.parametrize(
    "host", ["", "evil.example.org", "127.0.0.1.evil.org", "localhost:80:80", "127.0.0.1:x", "::1"]
)
def test_other_names_are_not(host: str) -> None:
    with pytest.raises(Refused, match="--allow-host") as refused:
        RULES.check(headers(host=host))
    assert refused.value.status == 421


def test_a_request_names_one_host() -> None:
    for given in ([], headers(host="localhost") * 2):
        with pytest.raises(Refused):
            RULES.check(given)


@pytest.mark.parametrize(
    "origin", ["", "null", "http://app.example.org", "https://app.example.org.evil.org", "http://localhost"]
)
def test_other_pages_are_not_let_in(origin: str) -> None:
    with pytest.raises(Refused, match="--allow-origin") as refused:
        RULES.check(headers(host="localhost", origin=origin))
    assert refused.value.status == 403


def test_a_request_comes_from_one_page() -> None:
    with pytest.raises(Refused):
        RULES.check([*headers(host="localhost"), *headers(origin="https://app.example.org") * 2])


def test_an_address_of_version_6_is_named_in_brackets() -> None:
    host_rules("fd00::1", (), ()).check(headers(host="[fd00::1]:80"))


@pytest.mark.parametrize("shown", ["Bearer a.b.c", "bearer  a.b.c "])
def test_a_token_is_read(shown: str) -> None:
    assert bearer_of(headers(authorization=shown)) == "a.b.c"


@pytest.mark.parametrize(
    "shown", ["", "a.b.c", "Basic a.b.c", "Bearer ", "Bearer a b", "Bearer ä", "Bearer " + "x" * 8_193]
)
def test_what_is_no_token_is_refused_without_its_text(shown: str) -> None:
    with pytest.raises(Refused) as refused:
        bearer_of(headers(authorization=shown))
    assert refused.value.status == 401
    assert "a b" not in str(refused.value)
    for several in ([], headers(authorization="Bearer a.b.c") * 2):
        with pytest.raises(Refused, match="a token of its own"):
            bearer_of(several)
