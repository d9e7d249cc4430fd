"""The configuration of coturn that is shipped, at a real coturn: who may relay, how much, and where to."""

import socket
import time
from contextlib import AsyncExitStack
from pathlib import Path

import pytest
from openrois_signaling.turn import turn_credential

from tests.support.turn import LISTENS, LOOSE, SECRET, coturn
from tests.support.turn_client import CREATE_PERMISSION, OK, PEER, TCP, turn_client

pytestmark = pytest.mark.usefixtures("turnserver")

FILE = Path(__file__).parents[2] / "packaging" / "turnserver.conf"
UNAUTHORIZED, FORBIDDEN, FAMILY_NOT_SERVED, WRONG_CREDENTIALS, TRANSPORT_NOT_SERVED = 401, 403, 440, 441, 442
OTHER_FAMILY, QUOTA_REACHED = 443, 486

OUTSIDE = (
    "8.8.8.8",
    "1.1.1.1",
    "192.0.1.1",
    "172.15.255.255",
    "172.32.0.1",
    "100.128.0.1",
    "198.20.0.1",
    "223.255.255.1",
)
INSIDE = (
    *("127.0.0.1", "127.1.2.3", "127.255.255.255", "0.0.0.0", "0.1.2.3"),
    *("10.0.0.1", "10.255.255.255", "172.16.0.1", "172.31.255.255", "192.168.0.0", "192.168.255.255"),
    *("100.64.0.1", "100.127.255.255", "169.254.0.1", "169.254.169.254"),
    *("192.0.0.8", "192.0.2.1", "192.88.99.1", "198.18.0.1", "198.19.255.255", "198.51.100.7", "203.0.113.10"),
    *("224.0.0.1", "239.255.255.250", "240.0.0.1", "255.255.255.255"),
)
OUTSIDE_6 = ("2606:4700::1", "2a00:1450::8888", "2001:4860::8888")
INSIDE_6 = (
    *("::1", "::", "::ffff:127.0.0.1", "::ffff:10.0.0.1", "::ffff:192.168.0.1", "::ffff:169.254.169.254"),
    *("::ffff:0.0.0.0", "::ffff:8.8.8.8", "::7f00:1", "::a00:1", "64:ff9b::7f00:1", "64:ff9b:1::a00:1"),
    *("2002:7f00:1::", "2002:a00:1::1", "2001:0:1::1", "2001:db8::1", "3fff::1", "100::1"),
    *("fc00::1", "fd00::1", "fdff:ffff::1", "fe80::1", "febf::1", "fec0::1", "ff02::1", "ff05::2", "5f00::1"),
)


def shipped(*added: str) -> str:
    """Return the file as set up with this address alone, and added lines."""
    return "\n".join((FILE.read_text(encoding="utf-8").replace("203.0.113.10", LISTENS, 2), *added))


def good(user: str = "alice", lifetime: float = 60, secret: str = SECRET) -> tuple[str, str]:
    """Return a username and a credential, as a gateway makes them."""
    return turn_credential(secret, int(time.time() + lifetime), user)


async def test_relay_needs_a_valid_credential_of_this_user(tmp_path: Path) -> None:
    name, credential = good()
    tried = {
        "nobody": ("", ""),
        "a credential that is over": good(lifetime=-1),
        "another secret": good(secret="another"),
        "a secret that is empty": good(secret=""),
        "made to last longer": (f"9{name}", credential),
        "another user's": (name.replace("alice", "bob"), credential),
        "without a time": ("alice", turn_credential(SECRET, 0, "alice")[1]),
    }
    async with coturn(tmp_path, shipped()) as server:
        said = {}
        for what, shown in tried.items():
            async with turn_client((LISTENS, server.port), *shown) as client:
                said[what] = await client.allocate()
        assert said == dict.fromkeys(tried, UNAUTHORIZED)
        async with turn_client((LISTENS, server.port), name, credential) as client:
            assert await client.allocate() == OK
            # What one has begun another cannot go on with.
            client.username, client.credential = good("bob")
            assert await client.permit("8.8.8.8") == WRONG_CREDENTIALS


async def test_shipped_configuration_admits_no_user(tmp_path: Path) -> None:
    async with coturn(tmp_path, shipped(), secret="") as server:
        for secret in ("", "<its first line>", SECRET):
            async with turn_client((LISTENS, server.port), *good(secret=secret)) as client:
                assert await client.allocate() == UNAUTHORIZED


async def test_nothing_inside_is_a_peer(tmp_path: Path) -> None:
    async with coturn(tmp_path, shipped()) as server, turn_client((LISTENS, server.port), *good()) as client:
        assert await client.allocate(transport=TCP) == TRANSPORT_NOT_SERVED
        assert await client.allocate(family=6) == FAMILY_NOT_SERVED
        assert await client.allocate() == OK
        permitted = {address: (await client.permit(address), await client.bind(address)) for address in OUTSIDE}
        assert permitted == dict.fromkeys(OUTSIDE, (OK, OK))
        refused = {address: (await client.permit(address), await client.bind(address)) for address in INSIDE}
        assert refused == dict.fromkeys(INSIDE, (FORBIDDEN, FORBIDDEN))
        spelled = {address: (await client.permit(address), await client.bind(address)) for address in INSIDE_6}
        assert spelled == dict.fromkeys(INSIDE_6, (OTHER_FAMILY, OTHER_FAMILY))
        # One that is inside among others is not let through with them.
        assert await client.ask(CREATE_PERMISSION, (PEER, "8.8.8.8"), (PEER, "10.0.0.1")) == FORBIDDEN


async def test_nothing_inside_is_a_peer_in_ipv6_either(tmp_path: Path) -> None:
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        pytest.skip("this machine has no IPv6")
    async with (
        coturn(tmp_path, shipped("relay-ip=::1")) as server,
        turn_client((LISTENS, server.port), *good()) as client,
    ):
        assert await client.allocate(family=6) == OK
        permitted = {address: (await client.permit(address), await client.bind(address)) for address in OUTSIDE_6}
        assert permitted == dict.fromkeys(OUTSIDE_6, (OK, OK))
        refused = {address: (await client.permit(address), await client.bind(address)) for address in INSIDE_6}
        assert refused == dict.fromkeys(INSIDE_6, (FORBIDDEN, FORBIDDEN))
        assert {await client.permit(address) for address in INSIDE} == {OTHER_FAMILY}


@pytest.mark.parametrize("arrives", [True, False])
async def test_relay_sends_only_to_permitted_addresses(tmp_path: Path, arrives: bool) -> None:
    """A server that lets loopback addresses pass shows that it would be seen."""
    settings = LOOSE if arrives else shipped()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as inside:
        inside.bind((LISTENS, 0))
        inside.setblocking(False)
        async with coturn(tmp_path, settings) as server, turn_client((LISTENS, server.port), *good()) as client:
            assert await client.allocate() == OK
            assert (await client.permit(LISTENS) == OK) == arrives
            client.send(LISTENS, inside.getsockname()[1], b"let me in")
            # It is asked after that, and answers in order.
            assert await client.permit("8.8.8.8") == OK
            try:
                came = inside.recv(100)
            except BlockingIOError:
                came = b""
        assert came == (b"let me in" if arrives else b"")


async def test_there_is_so_much_of_it(tmp_path: Path) -> None:
    async with coturn(tmp_path, shipped("total-quota=12")) as server, AsyncExitStack() as held:

        async def another(user: str, lifetime: float = 60) -> int:
            client = turn_client((LISTENS, server.port), *good(user, lifetime))
            return await (await held.enter_async_context(client)).allocate()

        # A newer credential of the same user does not make it more.
        assert [await another("alice", 60 + n) for n in range(10)] == [OK] * 8 + [QUOTA_REACHED] * 2
        assert [await another("bob") for _ in range(6)] == [OK] * 4 + [QUOTA_REACHED] * 2
        assert await another("carol") == QUOTA_REACHED
