from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_signaling.messages import IceServer
from openrois_streaming.network.servers import (
    SERVERS_LIMIT,
    StunServer,
    TurnServer,
    UnusableServer,
    read_server,
    read_servers,
)


@pytest.mark.parametrize(
    ("url", "server"),
    [
        ("stun:stun.example.org", StunServer("stun:stun.example.org", "stun.example.org", 3478)),
        ("stun:[2001:db8::1]:19302", StunServer("stun:[2001:db8::1]:19302", "2001:db8::1", 19302)),
        ("turn:10.0.0.1", TurnServer("turn:10.0.0.1", "10.0.0.1", 3478, "udp", False, "u", "secret")),
        ("turn:t?transport=tcp", TurnServer("turn:t?transport=tcp", "t", 3478, "tcp", False, "u", "secret")),
        ("turns:t", TurnServer("turns:t", "t", 5349, "tcp", True, "u", "secret")),
        ("turns:t:443?transport=tcp", TurnServer("turns:t:443?transport=tcp", "t", 443, "tcp", True, "u", "secret")),
    ],
)
def test_a_url_is_read(url: str, server: StunServer | TurnServer) -> None:
    assert read_server(url, "u", "secret") == server
    assert "secret" not in repr(server)


@pytest.mark.parametrize(
    ("url", "told"),
    [
        ("https://example.org", "not a STUN or TURN URL"),
        ("turn:", "not a STUN or TURN URL"),
        ("turn:a..b", "not a STUN or TURN URL"),
        ("turn:user@host", "not a STUN or TURN URL"),
        ("turn:h:123456", "not a STUN or TURN URL"),
        ("turn:h?transport=sctp", "not a STUN or TURN URL"),
        ("turn:h:0", "no valid port"),
        ("turn:h:70000", "no valid port"),
        ("stun:[::::1]", "not an IPv6 address"),
        ("stuns:h", "not supported"),
        ("stun:h?transport=udp", "has no transport"),
        ("turns:h?transport=udp", "not supported"),
    ],
)
def test_unusable_server_is_refused_with_reason(url: str, told: str) -> None:
    with pytest.raises(UnusableServer, match=told):
        read_server(url)


@given(st.text(max_size=60) | st.from_regex(r"(stuns?|turns?):[^ ]{0,40}", fullmatch=True))
def test_any_text_is_read_or_refused(url: str) -> None:
    with suppress(UnusableServer):
        server = read_server(url)
        assert 0 < server.port < 2**16
        server.host.encode("idna")


def test_servers_are_sorted_by_kind_without_unusable_ones() -> None:
    servers = read_servers(
        [
            IceServer(urls=("stun:s", "https://example.org", "stun:s:3478")),
            IceServer(urls=("turn:t", "turn:t?transport=tcp", "turn:t:3478"), username="u", credential="secret"),
        ]
    )
    assert [server.url for server in servers.stun] == ["stun:s"]
    assert [server.url for server in servers.turn] == ["turn:t", "turn:t?transport=tcp"]
    assert len(servers.unusable) == 1
    assert servers
    assert not read_servers([])


def test_only_so_many_are_asked() -> None:
    servers = read_servers([IceServer(urls=tuple(f"stun:s{number}" for number in range(20)))])
    assert len(servers.stun) == SERVERS_LIMIT
