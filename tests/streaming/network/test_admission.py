from collections.abc import Callable

import pytest
from openrois_streaming.network.admission import (
    BURST,
    CHECKS_PER_SECOND,
    CONTROL_SHARE,
    DTLS_PER_SECOND,
    PERSISTENCE,
    RESPITE,
    RTCP_PER_SECOND,
    SHARE,
    Admission,
    AdmissionSettings,
    TotalAdmission,
    Traffic,
    Verdict,
    media_traffic,
)


class Ingoing:
    """Several peer connections, and the time."""

    def __init__(self, peers: int = 1, **settings: int) -> None:
        self.now = 1000.0
        total = TotalAdmission(AdmissionSettings(**settings), lambda: self.now)
        self.peers = [Admission(total) for _ in range(peers)]

    def admitted(self, traffic: Traffic, number: int, octets: int = 100, peer: int = 0) -> int:
        """Say how many of so many datagrams that come at once are admitted."""
        return sum(self.peers[peer].judge(traffic, octets) is Verdict.ADMITTED for _ in range(number))


@pytest.mark.parametrize(
    ("traffic", "limit"),
    [
        (Traffic.RTCP, RTCP_PER_SECOND),
        (Traffic.DTLS, DTLS_PER_SECOND),
        (Traffic.CHECK, CHECKS_PER_SECOND),
        (Traffic.RTP, int(AdmissionSettings().peer_packets * BURST)),
    ],
)
def test_a_peer_may_send_so_many_packets_of_a_kind_at_once(traffic: Traffic, limit: int) -> None:
    ingoing = Ingoing()
    assert ingoing.admitted(traffic, limit + 50) == limit
    ingoing.now += 0.5
    assert ingoing.admitted(traffic, limit + 50) == (limit if traffic is Traffic.RTP else limit / 2)


def test_a_peer_may_send_so_many_bytes() -> None:
    ingoing = Ingoing(peer_bytes=100_000)
    assert ingoing.admitted(Traffic.RTP, 100, octets=1000) == 50
    ingoing.now += 0.1
    assert ingoing.admitted(Traffic.RTP, 100, octets=1000) == 10


def test_all_together_may_send_so_much_and_each_has_a_share_of_it() -> None:
    packets = Ingoing(peers=3, total_packets=1000)
    assert packets.admitted(Traffic.RTCP, 500, peer=2) == RTCP_PER_SECOND
    assert packets.admitted(Traffic.RTP, 700) == 500 - RTCP_PER_SECOND + SHARE - CONTROL_SHARE
    assert packets.admitted(Traffic.RTP, 700, peer=1) == SHARE - CONTROL_SHARE
    assert packets.peers[2].judge(Traffic.RTP, 100) is Verdict.ADMITTED
    assert packets.peers[1].judge(Traffic.RTP, 100) is Verdict.TOTAL_LIMIT
    octets = Ingoing(peers=2, total_bytes=100_000)
    assert octets.admitted(Traffic.RTP, 700, octets=1000) == 50 + SHARE - CONTROL_SHARE
    assert octets.peers[0].judge(Traffic.RTP, 1000) is Verdict.TOTAL_LIMIT
    assert not octets.peers[0].persists, "what others take is nothing to end a peer connection for"


def test_pictures_leave_a_part_of_the_share_to_reports_checks_and_input() -> None:
    ingoing = Ingoing(peers=2, total_packets=1000)
    ingoing.admitted(Traffic.RTP, 700)
    for _ in range(100):
        # A camera goes on while others take all there is; what keeps its peer connection alive, and is held, arrives.
        ingoing.admitted(Traffic.RTP, 500)
        ingoing.admitted(Traffic.RTP, 45, peer=1)
        for traffic in (Traffic.CHECK, Traffic.DTLS, Traffic.RTCP):
            assert ingoing.admitted(traffic, 2, peer=1) == 2
        ingoing.now += 0.1


def sends(ingoing: Ingoing, seconds: float, per_tenth: int) -> None:
    for _ in range(round(seconds * 10)):
        ingoing.admitted(Traffic.RTCP, per_tenth)
        ingoing.now += 0.1


def test_a_peer_that_stays_above_its_limit_is_known() -> None:
    ingoing = Ingoing()
    sends(ingoing, PERSISTENCE, per_tenth=RTCP_PER_SECOND)
    assert not ingoing.peers[0].persists
    sends(ingoing, 0.5, per_tenth=RTCP_PER_SECOND)
    assert ingoing.peers[0].persists
    ingoing.now += RESPITE
    assert not ingoing.peers[0].persists, "it has stopped"


@pytest.mark.parametrize("pattern", ["a burst now and then", "always within the limit"])
def test_a_peer_that_sends_much_now_and_then_goes_on(pattern: str) -> None:
    ingoing = Ingoing()
    for _ in range(20):
        if pattern == "a burst now and then":
            ingoing.admitted(Traffic.RTCP, 3 * RTCP_PER_SECOND)
            ingoing.now += RESPITE + 0.1
        else:
            sends(ingoing, 1, per_tenth=RTCP_PER_SECOND // 10)
        assert not ingoing.peers[0].persists


def test_a_camera_a_microphone_and_a_viewer_that_loses_much_are_never_cut() -> None:
    ingoing = Ingoing()
    for picture in range(300):
        packets = 80 if picture % 30 == 0 else 14  # 720p30 at 4 Mbit/s, a key frame each second
        for traffic, number, octets in ((Traffic.RTP, packets, 1200), (Traffic.RTP, 2, 120), (Traffic.RTCP, 2, 200)):
            assert ingoing.admitted(traffic, number, octets) == number
        ingoing.now += 1 / 30


@pytest.mark.parametrize(
    ("datagram", "traffic"),
    [
        (b"\x16\xfe\xfd", Traffic.DTLS),
        (b"\x81\xc9\x00\x07", Traffic.RTCP),
        (b"\x81\xcd\x00\x07", Traffic.RTCP),
        (b"\x80\xe0\x00\x07", Traffic.RTP),
        (b"\x80\x6f\x00\x07", Traffic.RTP),
        (b"\x80", Traffic.RTP),
    ],
)
def test_unencrypted_bytes_distinguish_reports_from_media(datagram: bytes, traffic: Traffic) -> None:
    assert media_traffic(datagram) is traffic


@pytest.mark.parametrize("name", ["peer_packets", "peer_bytes", "total_packets", "total_bytes"])
def test_settings_below_one_are_refused(name: str) -> None:
    make: Callable[..., AdmissionSettings] = AdmissionSettings
    with pytest.raises(ValueError, match=f"--{name.replace('_', '-')} must be 1 or more, not 0"):
        make(**{name: 0})
