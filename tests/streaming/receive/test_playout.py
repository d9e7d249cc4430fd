from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.receive.playout import PACKETS_LIMIT, Playout, SoundPacket

from tests.support.playout import ORIGIN, PACKET, FakeOpus, Hearing, hum, listen, microphone

LATE = 0.022
"""Seconds from the capture of a sample to its playing on a path without delay: 20 ms of packet, 2 ms of margin."""


def is_near(seconds: float, expected: float, tolerance: float = 0.0095) -> bool:
    return expected - 0.001 <= seconds <= expected + tolerance


class TestQuietPath:
    def test_sound_is_played_as_soon_as_its_packet_is_there(self) -> None:
        hearing = listen(microphone(3), 3)
        assert is_near(max(hearing.delays(0)), LATE, 0.001)
        assert hearing.playout.figures.concealed == 0

    def test_nothing_is_added_and_nothing_missing(self) -> None:
        hearing = listen(microphone(2), 2)
        heard = np.concatenate([block.samples for _, block in hearing.blocks])
        assert np.array_equal(heard, hum(0, len(heard)))
        assert len(heard) > 1.9 * 48_000

    def test_before_the_first_packet_there_is_nothing(self) -> None:
        playout = Playout(FakeOpus())
        assert playout.play(5.0) is None
        assert playout.delay(5.0) == 0.0

    def test_packets_in_another_order(self) -> None:
        swapped = [(at + (0.03 if number == 50 else 0), *rest) for number, (at, *rest) in enumerate(microphone(2))]
        hearing = listen(swapped, 2)  # type: ignore[arg-type]
        assert hearing.playout.figures.late == 0


class TestLosses:
    def test_a_lost_packet_is_made_up_for_and_forgotten(self) -> None:
        hearing = listen(microphone(6, lambda number: None if number == 100 else 0.0), 6)
        assert PACKET <= hearing.playout.figures.concealed <= PACKET + 480
        assert is_near(hearing.median(1, 1.9), LATE, 0.001)
        assert is_near(hearing.median(2.2), LATE)

    def test_after_a_burst_the_delay_is_back(self) -> None:
        hearing = listen(microphone(8, lambda number: None if 100 <= number < 115 else 0.0), 8)
        assert is_near(hearing.median(2.5, 7), LATE)
        assert 0.24 * 48_000 <= hearing.playout.figures.concealed < 15 * PACKET

    def test_many_losses_do_not_add_up(self) -> None:
        random = Random(1)
        hearing = listen(microphone(20, lambda number: None if random.random() < 0.1 else 0.0), 20)
        assert is_near(hearing.median(15), LATE)

    def test_a_long_gap_fades_to_silence_and_back(self) -> None:
        hearing = listen(microphone(4, lambda number: None if 50 <= number < 130 else 0.0), 4)
        falling = [int(block.samples[-1, 0]) for now, block in hearing.blocks if 1.04 < now < 1.3]
        assert falling == sorted(falling, reverse=True)
        assert falling[0] == 100
        silent = [block for now, block in hearing.blocks if 1.6 < now < 2.5]
        assert not any(block.samples.any() for block in silent)
        (rising,) = [block for now, block in hearing.blocks if is_near(now, 2.62 + 0.002, 0.009)][:1]
        assert abs(int(rising.samples[1, 0])) < 200
        assert is_near(hearing.median(3), LATE)

    def test_undecodable_packet_is_concealed(self) -> None:
        sent = microphone(3)
        sent[50] = (*sent[50][:2], b"bad")
        hearing = listen(sent, 3)
        assert hearing.playout.figures.concealed >= PACKET
        assert is_near(hearing.median(2), LATE)

    def test_packets_that_overlap_are_played_once(self) -> None:
        hearing = listen(sorted([*microphone(3), (1.0, 50 * PACKET - 100, b"0")]), 3)
        assert hearing.playout.figures.concealed <= PACKET + 480
        assert is_near(hearing.median(2), LATE)

    def test_late_packet_is_counted(self) -> None:
        hearing = listen(microphone(4, lambda number: 0.2 if number == 100 else 0.0), 4)
        assert hearing.playout.figures.late == 1
        assert is_near(hearing.median(3), LATE)


class TestJitter:
    @pytest.mark.parametrize("most", [0.02, 0.06, 0.12])
    def test_the_delay_is_what_the_path_needs(self, most: float) -> None:
        random = Random(2)
        hearing = listen(microphone(12, lambda number: most * random.random()), 12)
        assert is_near(hearing.median(6), LATE + most, 0.013)
        made_up = hearing.playout.figures.concealed / 48_000
        assert made_up < 0.05 * 12

    def test_a_path_that_becomes_quiet_is_noticed(self) -> None:
        random = Random(3)
        hearing = listen(microphone(16, lambda number: 0.1 * random.random() if number < 300 else 0.0), 16)
        assert hearing.median(4, 6) > 0.1
        assert is_near(hearing.median(11), LATE)

    def test_after_a_stall_the_delay_is_back_at_once(self) -> None:
        stall = [0.02 * (115 - number) if 100 <= number < 115 else 0.0 for number in range(500)]
        hearing = listen(microphone(6, lambda number: stall[number]), 6)
        assert is_near(hearing.median(2.8), LATE)
        assert hearing.playout.figures.skipped > 0

    def test_path_slow_at_first_becomes_fast(self) -> None:
        hearing = listen(microphone(12, lambda number: 0.05 if number < 100 else 0.0), 12)
        assert is_near(hearing.median(1, 2), LATE + 0.05, 0.002)
        assert is_near(hearing.median(8), LATE)


class TestClocks:
    @pytest.mark.parametrize("drift", [200e-6, -200e-6])
    def test_another_clock_is_followed(self, drift: float) -> None:
        hearing = listen(microphone(50, drift=drift), 50)
        figures = hearing.playout.figures
        assert figures.concealed == 0
        # By the end its clock is off by 10 ms.
        assert is_near(hearing.median(48) + drift * 49, LATE)
        assert (figures.shortened > 0) is (drift > 0)
        assert (figures.lengthened > 0) is (drift < 0)

    @pytest.mark.long
    @pytest.mark.timeout(900)
    @pytest.mark.parametrize("drift", [200e-6, -200e-6])
    def test_after_half_an_hour_sound_is_as_late_as_in_the_beginning(self, drift: float) -> None:
        # A microphone whose clock is fast has said all that it says a third of a second before the end.
        hearing = listen(microphone(1800, drift=drift), 1799)
        assert hearing.playout.figures.concealed == 0
        late = [hearing.median(at, at + 5) + drift * at for at in (600, 1200, 1790)]
        assert all(abs(each - LATE) < 0.04 for each in late), late

    def test_restarted_source_is_played(self) -> None:
        second = [(3 + at, timestamp + 10**7, data) for at, timestamp, data in microphone(3)]
        third = [(6 + at, timestamp + 5, data) for at, timestamp, data in microphone(3)]
        hearing = listen([*microphone(3), *second, *third], 9)
        assert hearing.playout.figures.concealed < 0.2 * 48_000
        assert hearing.blocks[-1][1].timestamp > ORIGIN
        assert hearing.blocks[-1][1].timestamp < ORIGIN + 10**6

    def test_a_listener_that_was_away_catches_up(self) -> None:
        hearing = listen(microphone(2), 2)
        later = [each for each in microphone(6) if each[0] >= 2]
        for at, timestamp, data in [each for each in later if each[0] < 2.5]:
            hearing.playout.add(SoundPacket(ORIGIN + timestamp, data), at)
        again = listen([each for each in later if each[0] >= 2.5], 3, begin=2.5, playout=hearing.playout)
        assert is_near(again.median(4.5), LATE)
        assert hearing.playout.figures.skipped >= 10


class TestBounds:
    def test_unplayed_packets_are_dropped(self) -> None:
        playout = Playout(FakeOpus())
        for at, timestamp, data in microphone(20):
            playout.add(SoundPacket(ORIGIN + timestamp, data), at)
        assert len(playout._waiting) == PACKETS_LIMIT

    @given(
        st.lists(
            st.tuples(st.floats(0, 3), st.integers(-5000, 200_000), st.sampled_from([b"0", b"960", b"bad"])),
            max_size=60,
        )
    )
    def test_anything_is_survived(self, arrivals: list[tuple[float, int, bytes]]) -> None:
        hearing: Hearing = listen(arrivals, 3)
        assert len(hearing.playout._waiting) <= PACKETS_LIMIT
