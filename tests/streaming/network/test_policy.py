import ipaddress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.network.policy import CandidatePolicy

LOOPBACK = ["127.0.0.1", "127.8.8.8", "::1"]
PRIVATE = ["10.0.0.1", "192.168.1.2", "172.16.0.9", "100.64.0.1", "fd00::2", "2002:a00:1::1", "64:ff9b::10.0.0.1"]
LINK_LOCAL = ["169.254.169.254", "fe80::1", "64:ff9b::a9fe:a9fe"]
NEVER = [
    *("0.0.0.0", "0.0.0.1", "::", "224.0.0.1", "ff02::1", "255.255.255.255", "240.0.0.1", "fec0::1"),
    *("::ffff:127.0.0.1", "::ffff:7f00:1", "::FFFF:10.0.0.1", "::ffff:203.0.114.7", "::127.0.0.1", "::7f00:1"),
    *("fe80::1%eth0", "2606:4700::1111%1", "64:ff9b::0.0.0.0", "2002:e000:1::1"),
    *("example.org", "", "x.local", "localhost", "1", "127.1", "0x7f.0.0.1", "0177.0.0.1", "2130706433", "127.0.0.1."),
    *("127.0.0.1 ", "\uff11\uff12\uff17.0.0.1", "[::1]", "127.0.0.1:80", "010.0.0.1"),
]
PUBLIC = ["203.0.114.7", "2606:4700::1111", "2002:cb00:7207::1"]


@pytest.mark.parametrize(
    ("policy", "permitted"),
    [
        (CandidatePolicy(), {*PUBLIC, *LOOPBACK, *PRIVATE}),
        (CandidatePolicy(allow_loopback=False), {*PUBLIC, *PRIVATE}),
        (CandidatePolicy(allow_private=False), {*PUBLIC, *LOOPBACK}),
        (CandidatePolicy(allow_loopback=False, allow_private=False), {*PUBLIC}),
        (CandidatePolicy(allow_link_local=True), {*PUBLIC, *LOOPBACK, *PRIVATE, *LINK_LOCAL}),
    ],
)
def test_a_deployment_says_which_addresses_may_be_used(policy: CandidatePolicy, permitted: set[str]) -> None:
    every = [*LOOPBACK, *PRIVATE, *LINK_LOCAL, *NEVER, *PUBLIC]
    assert {host for host in every if policy.permits(host)} == permitted


@pytest.mark.parametrize("carried", ["2001:0:7f00:1::", "2001:0:4136:e378:8000:63bf:80ff:fffe", "2002:7f00:1::"])
def test_an_address_within_an_address_has_to_be_permitted_too(carried: str) -> None:
    assert not CandidatePolicy(allow_loopback=False).permits(carried)


def test_ports_of_services_are_no_targets() -> None:
    policy = CandidatePolicy()
    assert [port for port in (0, 53, 1023, 1024, 65535, 65536) if policy.permits_target("10.0.0.1", port)] == [
        1024,
        65535,
    ]
    assert not policy.permits_target("224.0.0.1", 5000)


@given(st.text(max_size=40) | st.ip_addresses(v=4).map(str) | st.ip_addresses(v=6).map(str))
def test_public_profile_permits_internet_addresses_in_any_spelling(host: str) -> None:
    if CandidatePolicy(allow_loopback=False, allow_private=False).permits(host):
        address = ipaddress.ip_address(host)
        # Python calls no 6to4 address global since 3.13: the one that it carries is.
        assert (getattr(address, "sixtofour", None) or address).is_global
