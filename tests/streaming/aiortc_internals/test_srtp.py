import pylibsrtp
import pytest
from openrois_streaming.aiortc_internals import srtp
from openrois_streaming.aiortc_internals.srtp import PACKET_LIMIT, Protection, differences
from pylibsrtp import Policy, Session

HEADER = bytes.fromhex("80610001000000020000000a")
PROFILES = (
    (Policy.SRTP_PROFILE_AES128_CM_SHA1_80, 30),
    (Policy.SRTP_PROFILE_AEAD_AES_128_GCM, 28),
    (Policy.SRTP_PROFILE_AEAD_AES_256_GCM, 44),
)


def pair(profile: int, key: int) -> tuple[Protection, Session]:
    """What protects, and who reads it."""
    return (
        Protection(Session(Policy(key=bytes(key), ssrc_type=Policy.SSRC_ANY_OUTBOUND, srtp_profile=profile))),
        Session(Policy(key=bytes(key), ssrc_type=Policy.SSRC_ANY_INBOUND, srtp_profile=profile)),
    )


@pytest.mark.parametrize(("profile", "key"), PROFILES)
def test_protected_packets_can_be_read(profile: int, key: int) -> None:
    protection, reader = pair(profile, key)
    packets = [HEADER[:3] + bytes((number,)) + HEADER[4:] + bytes(100 * number) for number in range(3)]
    assert [reader.unprotect(packet) for packet in protection.rtp(packets)] == packets
    report = bytes.fromhex("80c90001000000010000000a")
    assert reader.unprotect_rtcp(protection.rtcp(report)) == report


def test_unprotectable_packet_is_refused() -> None:
    protection, _ = pair(*PROFILES[0])
    assert len(protection.rtp([HEADER + bytes(PACKET_LIMIT - 12)])[0]) == PACKET_LIMIT + 10
    for packet in (HEADER + bytes(PACKET_LIMIT - 11), b"short"):
        with pytest.raises(pylibsrtp.Error):
            protection.rtp([packet])


def test_another_binding_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    assert differences() == []
    monkeypatch.setattr(srtp.Protection, "rtp", lambda self, packets: packets)
    assert differences() == ["packets are protected otherwise"]
