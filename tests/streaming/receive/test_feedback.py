from aiortc.rtp import RtcpPacket, RtcpPsfbPacket, RtcpRrPacket, RtcpRtpfbPacket, unpack_remb_fci
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.receive import feedback
from openrois_streaming.receive.reception import Reception


def test_a_report_is_read_as_it_was_written() -> None:
    (packet,) = RtcpPacket.parse(feedback.receiver_report(1, 2, Reception(64, -3, 70_000, 5, 6, 7)))
    assert isinstance(packet, RtcpRrPacket)
    (about,) = packet.reports
    assert (packet.ssrc, about.ssrc, about.fraction_lost, about.packets_lost) == (1, 2, 64, -3)
    assert (about.highest_sequence, about.jitter, about.lsr, about.dlsr) == (70_000, 5, 6, 7)


@given(st.lists(st.integers(0, 300), min_size=1, unique=True).map(sorted), st.integers(0, 65_535))
def test_lost_packets_are_named(lost: list[int], start: int) -> None:
    sequences = [(start + each) & 0xFFFF for each in lost]
    (packet,) = RtcpPacket.parse(feedback.nack(1, 2, sequences))
    assert isinstance(packet, RtcpRtpfbPacket)
    assert (packet.fmt, packet.ssrc, packet.media_ssrc) == (1, 1, 2)
    assert [each & 0xFFFF for each in packet.lost] == sequences


def test_repeated_number_is_requested_once() -> None:
    assert feedback.nack(1, 2, [5, 5, 6]) == feedback.nack(1, 2, [5, 6])


def test_a_key_frame_is_asked_for() -> None:
    (packet,) = RtcpPacket.parse(feedback.picture_loss(1, 2))
    assert isinstance(packet, RtcpPsfbPacket)
    assert (packet.fmt, packet.ssrc, packet.media_ssrc, packet.fci) == (1, 1, 2, b"")


@given(st.integers(0, 10**12))
def test_a_limit_is_rounded_down(bitrate: int) -> None:
    (packet,) = RtcpPacket.parse(feedback.bitrate_limit(1, 2, bitrate))
    assert isinstance(packet, RtcpPsfbPacket)
    limit, sources = unpack_remb_fci(packet.fci)
    assert sources == [2]
    assert bitrate * (1 - 2**-17) <= limit <= bitrate
