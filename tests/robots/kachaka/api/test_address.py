"""The address of a robot, and why it cannot be reached."""

import pytest
from openrois_robots.kachaka.api.address import Address, read_address, unreachable


@pytest.mark.parametrize(
    ("text", "address", "target"),
    [
        ("192.168.1.20", Address("192.168.1.20"), "dns:///192.168.1.20:26400"),
        ("kachaka.local:1234", Address("kachaka.local", 1234), "dns:///kachaka.local:1234"),
        (" robot ", Address("robot"), "dns:///robot:26400"),
        ("fe80::1", Address("fe80::1"), "dns:///[fe80::1]:26400"),
        ("[fe80::1]", Address("fe80::1"), "dns:///[fe80::1]:26400"),
        ("[fe80::1]:77", Address("fe80::1", 77), "dns:///[fe80::1]:77"),
    ],
)
def test_an_address_is_read(text: str, address: Address, target: str) -> None:
    assert read_address(text) == address
    assert address.target == target


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("", "'' is no address of a robot"),
        ("http://robot", "'//robot' in 'http://robot' is no port"),
        ("two words", "is no address of a robot"),
        ("robot:", "'' in 'robot:' is no port"),
        ("robot:x", "'x' in 'robot:x' is no port"),
        ("robot:0", "'0' in 'robot:0' is no port"),
        ("robot:65536", "is no port"),
        ("robot:²", "is no port"),
        ("[fe80::1]x", "'x' in '[fe80::1]x' is no port"),
        ("-robot", "is no address of a robot"),
    ],
)
def test_what_is_none_is_named_with_what_is_expected(text: str, wrong: str) -> None:
    with pytest.raises(ValueError, match="expected HOST or HOST:PORT, such as 192") as raised:
        read_address(text)
    assert wrong in str(raised.value)


@pytest.mark.parametrize(
    ("details", "reason"),
    [
        ("failed to connect: connect: Connection refused (111)", "nothing listens at this port; "),
        ("DNS resolution failed for robot:26400", "this name is not known in the network; "),
        ("something new", "something new; "),
        ("", "it does not answer; "),
    ],
)
def test_a_robot_that_is_not_reached_is_explained_in_one_sentence(details: str, reason: str) -> None:
    assert unreachable(details) == (
        f"{reason}check --robot, and that the Kachaka API is switched on in the robot's app"
    )
