import logging
from dataclasses import replace

import pytest
from aiortc.rtp import RtcpByePacket, RtcpPacket, RtcpSdesPacket, RtcpSrPacket
from openrois_streaming.rtp.history import DEPTH
from openrois_streaming.rtp.ntp import middle
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.pacer import SILENCE
from openrois_streaming.send.sender import Negotiated, RtpSender

from tests.support.sending import NEGOTIATED, OFFSET, Sending, Wires, picture


@pytest.fixture
def sending() -> Sending:
    sending = Sending()
    sending.sender.start(NEGOTIATED, sending.wire)
    return sending


def test_a_frame_becomes_packets_of_one_time_and_the_last_is_marked(sending: Sending) -> None:
    sending.sender.send(picture(0, b"a", b"b", b"c", keyframe=True))
    sending.sender.send(picture(3, b"d"))
    packets = sending.packets
    assert [packet.payload for packet in packets] == [b"a", b"b", b"c", b"d"]
    assert [packet.marker for packet in packets] == [0, 0, 1, 1]
    assert {(packet.ssrc, packet.payload_type) for packet in packets} == {(0xCAFE, 97)}
    first = packets[0].sequence_number
    assert [packet.sequence_number for packet in packets] == [first, first + 1, first + 2, first + 3]
    assert first < 1 << 15
    assert packets[0].timestamp == packets[2].timestamp
    assert (packets[3].timestamp - packets[0].timestamp) % 2**32 == 9000
    assert sending.sequences == [0, 3]
    assert (sending.sender.figures.packets, sending.sender.figures.octets) == (4, 4)


def test_sound_is_not_marked(sending: Sending) -> None:
    sound = Sending("audio")
    sound.sender.start(NEGOTIATED, sound.wire)
    sound.sender.send(picture(0, keyframe=True))
    assert [packet.marker for packet in sound.packets] == [0]


def test_sequence_numbers_wrap_around(sending: Sending) -> None:
    sending.sender._sequence = 0xFFFF
    sending.sender.send(picture(0, b"a", b"b", keyframe=True))
    assert [packet.sequence_number for packet in sending.packets] == [0xFFFF, 0]


def test_without_extensions_a_packet_is_plain() -> None:
    sending = Sending()
    sending.sender.start(Negotiated(1, 97, 2, None, "", "0", None, None), sending.wire)
    sending.sender.send(picture(0, b"a", keyframe=True))
    sending.sender.missed([sending.packets[0].sequence_number])
    assert [len(data) for data in sending.wire.packets] == [13, 13]
    assert sending.wire.packets[0] == sending.wire.packets[1], "without RTX it is sent as it was"


def test_the_section_is_named_until_the_viewer_reports(sending: Sending) -> None:
    sending.sender.send(picture(0, keyframe=True))
    sending.sender.reported(ReceiverReport(7, 0.5, 3, 5), 0, 0)
    sending.sender.send(picture(1))
    named, plain = sending.wire.packets
    assert len(named) == len(plain) + 4
    assert sending.reports == [ReceiverReport(7, 0.5, 3, 5, None)]


def test_a_report_leaves_with_the_first_frame_and_then_about_once_a_second(sending: Sending) -> None:
    for number in range(61):
        sending.sender.send(picture(number, b"1234", keyframe=number == 0))
        sending.clock._move(sending.clock.now() + 1 / 30)
    assert 2 <= len(sending.wire.reports) <= 5
    report, names = RtcpPacket.parse(sending.wire.reports[0])
    assert isinstance(report, RtcpSrPacket)
    assert isinstance(names, RtcpSdesPacket)
    assert names.chunks[0].items == [(1, b"name")]
    info = report.sender_info
    assert (report.ssrc, info.packet_count, info.octet_count) == (0xCAFE, 1, 4)
    assert info.ntp_timestamp == (1_800_000_000 + 2_208_988_800) << 32


def test_reports_pair_the_time_of_day_with_the_time_of_capture(sending: Sending) -> None:
    sending.clock._move(1000.25)
    sending.sender.send(picture(0, keyframe=True))
    (report, _) = RtcpPacket.parse(sending.wire.reports[0])
    assert isinstance(report, RtcpSrPacket)
    captured = report.sender_info.ntp_timestamp / 2**32 - 2_208_988_800 - OFFSET - 0.25
    assert captured == pytest.approx(1000.0, abs=1e-5)
    assert (report.sender_info.rtp_timestamp - sending.packets[0].timestamp) % 2**32 == 90_000 // 4


def test_the_answer_to_a_report_gives_the_round_trip(sending: Sending) -> None:
    sending.sender.send(picture(0, keyframe=True))
    (report, _) = RtcpPacket.parse(sending.wire.reports[0])
    assert isinstance(report, RtcpSrPacket)
    sending.clock._move(1000.3)
    sending.sender.reported(ReceiverReport(7, 0.0, 0, 5), middle(report.sender_info.ntp_timestamp), 65536 // 4)
    assert sending.reports[0].round_trip_time == pytest.approx(0.05)
    assert sending.sender.figures.round_trip_time == pytest.approx(0.05)


def test_requested_packet_is_retransmitted_as_rtx(sending: Sending) -> None:
    sending.sender.send(picture(0, b"a", b"b", keyframe=True))
    first, second = sending.packets
    sending.sender.missed([second.sequence_number, 9, first.sequence_number])
    sending.sender.missed([second.sequence_number])
    again, other = sending.packets[2:]
    assert (again.ssrc, again.payload_type, again.marker, again.timestamp) == (0xBEEF, 98, 1, second.timestamp)
    assert again.payload == second.sequence_number.to_bytes(2, "big") + b"b"
    assert other.payload == first.sequence_number.to_bytes(2, "big") + b"a"
    assert other.sequence_number == again.sequence_number + 1
    assert (sending.sender.figures.retransmitted, sending.sender.figures.refused) == (2, 1)


def test_a_viewer_that_misses_more_than_may_be_repeated_waits_for_a_key_frame(sending: Sending) -> None:
    sending.sender.send(picture(0, *[bytes(1000)] * 10, keyframe=True))
    missing = [packet.sequence_number for packet in sending.packets]
    for moment in range(30):
        sending.clock._move(1001.0 + moment)
        sending.sender.missed(missing)
    assert sending.gaps == [(0, True)]
    sending.sender.send(picture(1, b"p"))
    assert sending.sequences == [0]
    sending.sender.send(picture(2, b"i", keyframe=True))
    sending.sender.send(picture(3, b"p"))
    assert sending.sequences == [0, 2, 3]
    sending.sender.missed([sending.packets[-1].sequence_number])
    assert sending.packets[-1].payload[2:] == b"p"
    assert sending.gaps == [(0, True)]


def test_of_what_is_missed_no_more_is_looked_for_than_is_remembered(sending: Sending) -> None:
    sending.sender.send(picture(0, keyframe=True))
    sending.sender.missed([sending.packets[0].sequence_number] * 20_000)
    assert (sending.sender.figures.retransmitted, sending.sender.figures.refused) == (1, DEPTH - 1)


def test_pictures_that_no_sound_belongs_to_are_shown_at_once(sending: Sending) -> None:
    at_once, as_it_likes = b"\x42\x00\x00\x00", b"\x42\x00\x03\xe8"
    negotiated = replace(NEGOTIATED, playout_delay_id=4)
    sending.sender.start(negotiated, sending.wire)
    sound = RtpSender("audio", sending, sending.outlet)
    sound.start(NEGOTIATED, Wires())
    sending.sender.send(picture(0, b"a", keyframe=True))
    assert at_once in sending.wire.packets[-1]
    sound.send(picture(0, b"s", keyframe=True))
    sending.sender.send(picture(1, b"b"))
    assert as_it_likes in sending.wire.packets[-1]
    sending.sender.missed([sending.packets[0].sequence_number])
    assert as_it_likes in sending.wire.packets[-1]
    sending.clock._move(sending.clock.now() + SILENCE)
    sending.sender.send(picture(2, b"c"))
    assert at_once in sending.wire.packets[-1]


def test_before_its_start_and_after_its_end_it_sends_nothing() -> None:
    sending = Sending()
    sending.sender.send(picture(0, keyframe=True))
    sending.sender.missed([1])
    sending.sender.reported(ReceiverReport(7, 0.0, 0, 5), 0, 0)
    sending.sender.stop()
    assert sending.gaps == []
    sending.sender.start(NEGOTIATED, sending.wire)
    assert sending.gaps == [(0, True)], "a key frame is needed in the place of the lost one"
    sending.sender.send(picture(1))
    sending.sender.send(picture(2, keyframe=True))
    assert sending.sequences == [2]
    assert sending.sender.figures.dropped == 2
    sending.sender.stop()
    sending.sender.stop()
    assert isinstance(RtcpPacket.parse(sending.wire.reports[-1])[-1], RtcpByePacket)
    sending.sender.send(picture(3))
    assert sending.sequences == [2]


def test_sound_starts_with_any_block() -> None:
    sending = Sending("audio")
    sending.sender.send(picture(0))
    sending.sender.start(NEGOTIATED, sending.wire)
    sending.sender.stop()
    sending.sender.start(NEGOTIATED, sending.wire)
    sending.sender.send(picture(1))
    assert (sending.sequences, sending.gaps) == ([1], [])


def test_viewers_feedback_reaches_the_listener(sending: Sending) -> None:
    sending.sender.estimated(1_000_000)
    sending.sender.undecodable()
    assert (sending.estimates, sending.requests) == ([1_000_000], 1)


def test_failure_is_logged_once_and_contained(sending: Sending, caplog: pytest.LogCaptureFixture) -> None:
    sending.wire.failure = RuntimeError("no key")
    with caplog.at_level(logging.ERROR):
        for number in range(3):
            sending.sender.send(picture(number, keyframe=True))
    assert sending.sender.failed
    assert sending.sequences == []
    assert caplog.text.count("no key") == 1


def test_a_large_picture_is_paced_and_keeps_its_order_and_time(sending: Sending) -> None:
    sending.outlet.pacer.rate = 5_000_000
    large = picture(0, *(bytes((number,)) * 1000 for number in range(60)), keyframe=True)
    sending.sender.send(large)
    assert 0 < len(sending.packets) < 60
    assert sending.sequences == []
    sending.alarms.advance(0.2)
    packets = sending.packets
    assert [packet.payload[0] for packet in packets] == list(range(60))
    assert [packet.marker for packet in packets] == [0] * 59 + [1]
    assert len({packet.timestamp for packet in packets}) == 1
    assert len({packet.sequence_number for packet in packets}) == 60
    assert sending.sequences == [0]


def test_late_pictures_are_dropped_up_to_the_next_key_frame(sending: Sending) -> None:
    sending.outlet.pacer.rate = 5_000_000
    for number in range(4):
        sending.sender.send(picture(number, *[bytes(1000)] * 200, keyframe=number == 0))
    assert sending.gaps == [(2, True)]
    sending.sender.send(picture(4))
    sending.alarms.advance(1.0)
    sending.sender.send(picture(5))
    sending.sender.send(picture(6, keyframe=True))
    sending.sender.send(picture(7))
    assert sending.sequences == [0, 6, 7]
    assert sending.sender.figures.dropped == 5


def test_padding_sends_packets_again_as_rtx(sending: Sending) -> None:
    sending.sender.send(picture(0, b"a" * 1000, b"b" * 1000, keyframe=True))
    assert sending.sender.pad(1500) == 2000
    assert sending.sender.pad(500) == 1000
    assert {packet.ssrc for packet in sending.packets[2:]} == {0xBEEF}
    assert sending.sender.figures.padded == len(sending.packets) - 2 == 3
    assert sending.sender.figures.retransmitted == 0


def test_there_is_no_padding_without_rtx_or_media(sending: Sending) -> None:
    assert sending.sender.pad(1000) == 0
    plain = Sending()
    assert plain.sender.pad(100) == 0
    plain.sender.start(Negotiated(1, 97, 2, None, "", "0", None, None), plain.wire)
    plain.sender.send(picture(0, keyframe=True))
    assert plain.sender.pad(1000) == 0
    assert len(plain.wire.packets) == 1


def test_failure_while_retransmitting_or_stopping_is_noted(sending: Sending) -> None:
    sending.sender.send(picture(0, b"a", keyframe=True))
    sending.wire.failure = RuntimeError("no key")
    sending.sender.missed([sending.packets[0].sequence_number])
    assert sending.sender.failed
    leaving = Sending()
    leaving.sender.start(NEGOTIATED, leaving.wire)
    leaving.wire.send_report = lambda packet: 1 / 0  # type: ignore[assignment,method-assign]
    leaving.sender.stop()
    assert leaving.sender.failed


def test_waiting_frames_are_not_sent_after_stop(sending: Sending) -> None:
    sending.outlet.pacer.rate = 5_000_000
    sending.sender.send(picture(0, *[bytes(1000)] * 100, keyframe=True))
    sent = len(sending.packets)
    sending.sender.stop()
    sending.alarms.advance(1.0)
    assert len(sending.packets) == sent


@pytest.mark.parametrize("abs_send_time_id", [3, None])
def test_once_a_second_the_first_packet_of_a_picture_says_when_it_was_captured(abs_send_time_id: int | None) -> None:
    sending = Sending()
    named = replace(NEGOTIATED, mid_id=None, abs_send_time_id=abs_send_time_id, capture_time_id=5)
    sending.sender.start(named, sending.wire)
    for number in range(45):
        sending.sender.send(picture(number, b"a", b"b", keyframe=number == 0))
        sending.clock._move(sending.clock.now() + 1 / 30)
    place = 20 if abs_send_time_id else 16
    telling = [index for index, data in enumerate(sending.wire.packets) if data[place : place + 1] == b"\x57"]
    assert (telling[0], len(telling)) == (0, 2)
    later = telling[1] // 2
    assert 30 <= later <= 31
    assert [packet.payload for packet in sending.packets] == [b"a", b"b"] * 45
    told = sending.wire.packets[2 * later][place + 1 : place + 9]
    captured = int.from_bytes(told, "big") / 2**32 - 2_208_988_800
    assert captured == pytest.approx(1000.0 + later / 30 + OFFSET, abs=1e-5)
