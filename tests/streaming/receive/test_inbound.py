import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.codecs import H264, VP8
from openrois_streaming.receive.inbound import (
    RTX,
    SILENCE,
    Arrived,
    Codec,
    Inbound,
    Negotiated,
    SenderReport,
    Unwrapped,
)
from openrois_streaming.receive.remote_time import RemoteClock

CODECS = (
    Codec(96, VP8, 90_000, None),
    Codec(97, RTX, 90_000, 96),
    Codec(98, "video/VP9", 90_000, None),
    Codec(99, RTX, 90_000, 98),
    Codec(100, RTX, 90_000, 97),
    Codec(101, RTX, 90_000, None),
)

ANY_PACKET = st.builds(
    Arrived,
    payload_type=st.sampled_from([96, 97, 98]),
    sequence=st.integers(0, 65_535),
    timestamp=st.integers(0, 2**32 - 1),
    marker=st.booleans(),
    ssrc=st.integers(0, 5),
    payload=st.binary(max_size=5),
    send_time=st.none(),
    size=st.just(9),
)


class Receiver:
    def __init__(self, sources: tuple[int, ...] = (1,), repairs: dict[int, int] | None = None) -> None:
        self.changes = 0
        self.unused: list[int] = []
        self.inbound = Inbound(frozenset({VP8, H264}), RemoteClock(), self._changed, self.unused.append)
        self.inbound.negotiated(Negotiated(CODECS, sources, {2: 1} if repairs is None else repairs))

    def _changed(self) -> None:
        self.changes += 1


def packet(sequence: int, *, ssrc: int = 1, payload_type: int = 96, payload: bytes = b"x") -> Arrived:
    return Arrived(payload_type, sequence, 3000 * sequence, True, ssrc, payload, None, len(payload))


def test_numbers_are_unwrapped() -> None:
    inbound = Receiver().inbound
    first, second = (inbound.receive_packet(packet(each), 0.0) for each in (65_535, 0))
    assert first is not None
    assert second is not None
    assert second.sequence - first.sequence == 1


@pytest.mark.parametrize("payload_type", [95, 98])
def test_undecodable_packets_are_ignored(payload_type: int) -> None:
    inbound = Receiver().inbound
    unknown = packet(5, payload_type=payload_type)
    assert not inbound.knows(unknown)
    assert inbound.receive_packet(unknown, 0.0) is None


class TestRepairs:
    def test_retransmission_restores_the_original(self) -> None:
        inbound = Receiver().inbound
        original = inbound.receive_packet(packet(65_535), 0.0)
        inbound.receive_packet(packet(0), 0.0)
        again = packet(7, ssrc=2, payload_type=97, payload=b"\xff\xffx")._replace(timestamp=3000 * 65_535)
        assert inbound.receive_packet(again, 0.1) == original

    def test_an_unannounced_source_of_repairs_is_of_what_is_received(self) -> None:
        inbound = Receiver(repairs={}).inbound
        inbound.receive_packet(packet(5), 0.0)
        assert inbound.receive_packet(packet(7, ssrc=77, payload_type=97, payload=b"\x00\x04x"), 0.0) is not None

    @pytest.mark.parametrize(
        ("ssrc", "payload_type", "payload"),
        [
            (2, 97, b"\x00"),
            (3, 97, b"\x00\x04x"),
            (2, 99, b"\x00\x04x"),
            (2, 100, b"\x00\x04x"),
            (2, 101, b"\x00\x04x"),
        ],
    )
    def test_rtx_without_original_is_ignored(self, ssrc: int, payload_type: int, payload: bytes) -> None:
        inbound = Receiver(repairs={2: 1, 3: 9}).inbound
        repair = packet(7, ssrc=ssrc, payload_type=payload_type, payload=payload)
        assert inbound.receive_packet(repair, 0.0) is None
        inbound.receive_packet(packet(5), 0.0)
        assert inbound.receive_packet(repair, 0.0) is None


class TestSources:
    def test_another_source_is_received_when_the_first_is_silent(self) -> None:
        receiver = Receiver()
        receiver.inbound.receive_packet(packet(5), 0.0)
        assert receiver.inbound.receive_packet(packet(500, ssrc=8), SILENCE / 2) is None
        assert receiver.unused == [8]
        assert receiver.inbound.receive_packet(packet(501, ssrc=8), SILENCE) is not None
        assert receiver.changes == 1
        assert receiver.inbound.source is not None
        assert receiver.inbound.source.ssrc == 8
        assert receiver.inbound.receive_packet(packet(6), SILENCE + 0.01) is None
        # What was announced can come again.
        assert receiver.unused == [8]
        receiver.inbound.receive_packet(packet(7), 2 * SILENCE)
        assert receiver.unused == [8, 8]

    def test_reports_of_the_source_date_what_it_sends(self) -> None:
        inbound = Receiver().inbound
        inbound.reported(SenderReport(1, 0, 1000.0, 0), 0.0)
        assert inbound.captured(5, 7.0).at == 7.0
        first = inbound.receive_packet(packet(5), 10.0)
        assert first is not None
        inbound.reported(SenderReport(1, 1 << 16, 1000.0, 15_000), 10.0)
        inbound.reported(SenderReport(9, 1 << 16, 2000.0, 15_000), 10.0)
        assert inbound.captured(first.timestamp + 90_000, 12.0).at == pytest.approx(11.0)
        assert inbound.source is not None
        report = inbound.source.reception.report(10.5)
        assert report is not None
        assert (report.last_report, report.delay) == (1, 32_768)

    @given(st.lists(ANY_PACKET, max_size=50))
    def test_anything_is_survived(self, packets: list[Arrived]) -> None:
        receiver = Receiver()
        for number, each in enumerate(packets):
            receiver.inbound.receive_packet(each, number * 0.03)
        assert set(receiver.unused) <= {0, 3, 4, 5}


def test_the_first_is_taken_as_it_is() -> None:
    assert Unwrapped(16)(5) % 65536 == 5


def test_numbers_go_on_over_the_wrap() -> None:
    unwrapped = Unwrapped(16)
    first = unwrapped(65534)
    assert [unwrapped(each) - first for each in (65535, 0, 2, 1)] == [1, 2, 4, 3]


def test_older_numbers_stay_older() -> None:
    unwrapped = Unwrapped(16)
    first = unwrapped(1)
    assert unwrapped(65535) == first - 2
    assert unwrapped(2) == first + 1


def test_looking_does_not_move_it() -> None:
    unwrapped = Unwrapped(16)
    assert unwrapped.nearest(7) == unwrapped(7)
    unwrapped.nearest(30_000)
    assert unwrapped(40_000) - unwrapped(7) == 40_000 - 7 - 65536


@given(st.lists(st.integers(-30_000, 30_000)), st.integers(0, 65535))
def test_steps_of_less_than_half_are_followed(steps: list[int], start: int) -> None:
    unwrapped = Unwrapped(16)
    number = unwrapped(start)
    for step in steps:
        newest = number
        number = max(number, number + step)
        assert unwrapped(newest + step & 0xFFFF) == newest + step
