import logging

import pytest
from openrois_signaling.messages import IceServer
from openrois_streaming.connection import usable_servers


def test_servers_come_as_aiortc_takes_them_and_unreadable_ones_are_left_out(caplog: pytest.LogCaptureFixture) -> None:
    servers = [
        IceServer(urls=("stun:stun.example.org", "https://example.org")),
        IceServer(urls=("turn:turn.example.org?transport=tcp",), username="u", credential="secret"),
    ]
    with caplog.at_level(logging.WARNING):
        usable = usable_servers(servers)
    assert [(each.urls, each.username, each.credential) for each in usable] == [
        ("stun:stun.example.org", None, None),
        ("turn:turn.example.org?transport=tcp", "u", "secret"),
    ]
    assert "https://example.org" in caplog.text
    assert "secret" not in caplog.text
