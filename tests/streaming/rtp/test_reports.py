import pytest
from aiortc.rtp import RtcpByePacket, RtcpPacket, RtcpSdesPacket, RtcpSrPacket
from openrois_streaming.rtp.ntp import middle, ntp
from openrois_streaming.rtp.reports import RoundTrip, bye, sender_report


@pytest.mark.parametrize("cname", ["", "a", "name", "{3c1d0e5e-1c2a}", "n" * 300])
def test_a_report_is_read_as_it_was_meant(cname: str) -> None:
    data = sender_report(7, 1_800_000_000.5, 90, 2**32 + 5, 600, cname) + bye(7)
    report, names, farewell = RtcpPacket.parse(data)
    assert isinstance(report, RtcpSrPacket)
    assert isinstance(names, RtcpSdesPacket)
    assert isinstance(farewell, RtcpByePacket)
    info = report.sender_info
    assert (report.ssrc, info.ntp_timestamp, info.rtp_timestamp) == (7, ntp(1_800_000_000.5), 90)
    assert (info.packet_count, info.octet_count) == (5, 600)
    assert (names.chunks[0].ssrc, names.chunks[0].items) == (7, [(1, cname[:255].encode())])
    assert farewell.sources == [7]


def test_the_round_trip_is_what_is_left_of_the_time_to_the_answer() -> None:
    trip = RoundTrip()
    trip.sent(ntp(1000.0), 5.0)
    trip.answered(middle(ntp(1000.0)), 65536 // 2, 5.6)
    assert trip.smoothed == pytest.approx(0.1)
    trip.answered(middle(ntp(1000.0)), 0, 5.3)
    assert trip.smoothed == pytest.approx(0.1 + 0.15 * 0.2)


def test_answers_that_cannot_be_are_ignored() -> None:
    trip = RoundTrip()
    for number in range(10):
        trip.sent(ntp(1000.0 + number), float(number))
    trip.answered(0, 0, 10.0)
    trip.answered(middle(ntp(1000.0)), 0, 10.0)
    trip.answered(middle(ntp(1005.0)), 65536 * 60, 10.0)
    trip.answered(middle(ntp(1005.0)), 0, 60.0)
    assert trip.smoothed is None
    trip.answered(middle(ntp(1002.0)), 0, 2.5)
    assert trip.smoothed == pytest.approx(0.5)
