import socket
from pathlib import Path

import pytest
from openrois_avatar.link.address import Address, TcpAddress, UnixAddress, connect_socket, parse_address
from openrois_avatar.link.messages import LinkError


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("unix:/tmp/a:b", UnixAddress("/tmp/a:b")),
        ("tcp:127.0.0.1:9", TcpAddress("127.0.0.1", 9)),
        ("tcp:localhost:65535", TcpAddress("localhost", 65535)),
        ("tcp:[::1]:0", TcpAddress("::1", 0)),
    ],
)
def test_addresses_are_read_and_written(text: str, address: Address) -> None:
    assert parse_address(text) == address
    assert str(address) == text


@pytest.mark.parametrize(
    "text",
    [
        "",
        "unix:",
        "tcp:",
        "tcp:host",
        "tcp::1",
        "tcp:h:65536",
        "tcp:h:x",
        "tcp:h:٣",
        "http://h:1",
        "tcp:h:" + "9" * 5000,
    ],
)
def test_anything_else_is_refused(text: str) -> None:
    with pytest.raises(LinkError, match="expected unix:/path or tcp:host:port, not "):
        parse_address(text)


def test_failed_connection_names_the_address(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match=r"cannot connect to unix:.*missing: .*; check that the adapter runs"):
        connect_socket(UnixAddress(str(tmp_path / "missing")), 1)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    with pytest.raises(LinkError, match=f"cannot connect to tcp:127.0.0.1:{port}"):
        connect_socket(TcpAddress("127.0.0.1", port), 1)


def test_small_messages_leave_at_once_over_tcp() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        address = TcpAddress("127.0.0.1", listener.getsockname()[1])
        with connect_socket(address, 1) as stream:
            assert stream.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_unix_socket_is_reached_by_its_path(tmp_path: Path) -> None:
    path = str(tmp_path / "s")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        with connect_socket(UnixAddress(path), 1) as stream:
            assert stream.gettimeout() == 1
