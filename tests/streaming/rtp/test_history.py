from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.rtp.history import (
    DEPTH,
    KEY_FRAME_TIMES,
    LONGEST_WAIT,
    OBSOLETE_SHARE,
    RESERVE,
    SHARE,
    SHORTEST_WAIT,
    History,
    SentFrame,
    SentPacket,
)


def filled(packets: int, first: int = 0, length: int = 1000) -> History:
    """A history of frames of one packet each; nothing was earned with them."""
    history = History()
    for sequence in range(first, first + packets):
        history.add(SentFrame(sequence & 0xFFFF, 90, True, (bytes(length),)), 0)
    return history


def test_recent_packet_is_retransmitted() -> None:
    history = History()
    history.add(SentFrame(65535, 90, True, (b"a", b"b", b"c")), 3)
    history.add(SentFrame(2, 180, False, (b"d",)), 1)
    assert history.again(65535, 1.0, None) == SentPacket(65535, 90, False, b"a")
    assert history.again(1, 1.0, None) == SentPacket(1, 90, True, b"c")
    assert history.again(2, 1.0, None) == SentPacket(2, 180, False, b"d")
    assert history.again(3, 1.0, None) is None
    assert history.again(1 + DEPTH, 1.0, None) is None
    assert history.refused == 0


def test_old_packet_is_dropped() -> None:
    history = filled(DEPTH + 1)
    assert history.find(0) is None
    assert history.find(1) is not None


@given(st.lists(st.integers(1, 3 * DEPTH), min_size=1, max_size=6), st.integers(0, 0xFFFF))
def test_the_newest_packets_are_remembered_however_they_came(counts: list[int], first: int) -> None:
    history, sequence = History(), first
    for count in counts:
        history.add(SentFrame(sequence & 0xFFFF, 90, True, (b"",) * count), 0)
        sequence += count
    remembered = [history.find(each & 0xFFFF) for each in range(sequence - min(DEPTH, sum(counts)), sequence)]
    assert None not in remembered
    assert len(history._frames) == DEPTH


def test_a_packet_is_repeated_once_in_a_round_trip() -> None:
    for trip, wait in ((None, SHORTEST_WAIT), (0.001, SHORTEST_WAIT), (0.1, 0.1), (9.0, LONGEST_WAIT)):
        history = filled(2)
        assert history.again(1, 1.0, trip) is not None
        assert history.again(1, 1.0 + wait * 0.9, trip) is None
        assert history.again(1, 1.0 + wait * 1.1, trip) is not None
        assert history.refused == 1


def test_repetitions_stay_within_a_share_of_what_was_sent() -> None:
    history = filled(1000)

    def repeated(now: float) -> int:
        return sum(history.again(sequence, now, None) is not None for sequence in range(1000))

    assert repeated(1.0) == RESERVE // 1000
    history.add(SentFrame(1000, 90, True, (b"",)), 10_000)
    assert repeated(2.0) == 10_000 * SHARE // 1000
    history.add(SentFrame(1001, 90, True, (b"",)), 100 * RESERVE)
    assert repeated(3.0) == RESERVE // 1000


def repeated(history: History, sequences: range, now: float) -> int:
    return sum(history.again(sequence & 0xFFFF, now, None) is not None for sequence in sequences)


def beyond_help(history: History) -> bool:
    return history.exhausted


def test_packets_before_the_key_frame_leave_budget_for_it() -> None:
    history = filled(500)
    history.key_frame(500, 20_000)
    history.add(SentFrame(500, 90, True, (bytes(1000),) * 20), 0)
    assert repeated(history, range(500), 1.0) == RESERVE * (1 - OBSOLETE_SHARE) // 1000
    assert history.refused > 0
    assert not beyond_help(history)
    assert repeated(history, range(500, 520), 2.0) == 20


def test_a_key_frame_can_be_repeated_whatever_was_repeated_before_it() -> None:
    history = filled(500)
    repeated(history, range(500), 1.0)
    assert beyond_help(history)
    history.key_frame(500, 20_000)
    history.add(SentFrame(500, 90, True, (bytes(1000),) * 20), 0)
    assert not beyond_help(history)
    for number in range(KEY_FRAME_TIMES):
        assert repeated(history, range(500, 520), 2.0 + number) == 20
    assert not beyond_help(history)
    assert repeated(history, range(500, 520), 9.0) == 0
    assert beyond_help(history)


def test_long_after_a_key_frame_nothing_that_is_remembered_was_before_it() -> None:
    history = History()
    history.key_frame(0, 1000)
    for sequence in range(3 * 0x8000):
        history.add(SentFrame(sequence & 0xFFFF, 90, True, (bytes(1000),)), 0)
    assert repeated(history, range(3 * 0x8000 - DEPTH, 3 * 0x8000), 1.0) == RESERVE // 1000


def test_a_large_key_frame_keeps_its_room_while_pictures_follow() -> None:
    history = History()
    history.key_frame(0, RESERVE)
    history.add(SentFrame(0, 90, True, (bytes(1000),) * 100), RESERVE)
    history.add(SentFrame(100, 180, True, (b"",)), 10)
    assert sum(repeated(history, range(100), now) for now in (1.0, 2.0, 3.0)) == 100 * KEY_FRAME_TIMES


def test_retransmission_times_are_dropped_in_time() -> None:
    history = filled(DEPTH, length=1)
    for moment in range(3):
        for sequence in range(DEPTH):
            assert history.again(sequence, float(moment), None) is not None


@given(st.lists(st.tuples(st.integers(0, 70_000), st.floats(0, 10), st.integers(0, 1200)), max_size=60))
def test_a_receiver_that_lies_gets_no_more_than_the_budget(asked: list[tuple[int, float, int]]) -> None:
    history, sent, repeated = History(), 0, 0
    for sequence, now, length in asked:
        history.add(SentFrame(sequence & 0xFFFF, 90, True, (bytes(length),)), length)
        sent += length
        for _ in range(50):
            again = history.again(sequence & 0xFFFF, now, 0.0)
            repeated += len(again.payload) if again else 0
    assert repeated <= RESERVE + SHARE * sent
