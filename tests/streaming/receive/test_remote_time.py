import pytest
from openrois_streaming.receive.remote_time import CaptureTimes, LowestOffset, RemoteClock

RATE = 90_000


class TestLowestOffset:
    def test_the_least_is_kept_for_a_window(self) -> None:
        offset = LowestOffset(10)
        for at, value in ((0, 5.0), (5, 3.0), (9, 4.0)):
            offset.add(value, at)
        assert offset.value == 3.0
        offset.add(4.5, 11)
        assert offset.value == 3.0
        offset.add(6.0, 21)
        assert offset.value == 4.5

    def test_reset_offset_is_none(self) -> None:
        offset = LowestOffset(10)
        offset.add(5.0, 0)
        offset.reset()
        assert offset.value is None


class TestRemoteClock:
    def test_without_a_report_nothing_is_known(self) -> None:
        assert RemoteClock().local(5.0) is None

    def test_the_fastest_report_counts(self) -> None:
        clock = RemoteClock()
        for remote, delay in ((1000.0, 0.05), (1001.0, 0.02), (1002.0, 0.09)):
            clock.add_report(remote, remote - 900 + delay)
        assert clock.local(1003.0) == pytest.approx(103.02)

    def test_a_step_is_followed(self) -> None:
        clock = RemoteClock()
        clock.add_report(1000.0, 100.0)
        clock.add_report(5000.0, 101.0)
        assert clock.local(5001.0) == pytest.approx(102.0)


class TestCaptureTimes:
    def test_nothing_has_come(self) -> None:
        assert CaptureTimes(RATE, RemoteClock()).captured(7, 5.0).at == 5.0

    def test_without_a_report_the_fastest_packet_counts(self) -> None:
        times = CaptureTimes(RATE, RemoteClock())
        times.arrived(0, 100.05)
        times.arrived(RATE, 101.02)
        assert times.captured(2 * RATE, 102.5).at == pytest.approx(102.02)
        assert times.captured(3 * RATE, 103.0).at == 103.0

    def test_a_source_that_starts_anew(self) -> None:
        times = CaptureTimes(RATE, RemoteClock())
        times.arrived(0, 100.0)
        times.arrived(100 * RATE, 101.0)
        assert times.captured(101 * RATE, 102.5).at == pytest.approx(102.0)

    def test_two_sources_of_one_sender_are_in_time(self) -> None:
        remote = RemoteClock()
        video, audio = CaptureTimes(RATE, remote), CaptureTimes(48_000, remote)
        # At their time 1000.0 the timestamps are 500 and 7000; ours is 900 less, and the reports take 20 and 70 ms.
        video.reported(1000.0, 500, 100.02)
        audio.reported(1000.0, 7000, 100.07)
        assert video.captured(500 + RATE, 102.0).at == pytest.approx(101.02)
        assert audio.captured(7000 + 48_000, 102.0).at == pytest.approx(101.02)

    def test_the_sender_says_when_on_its_own_clock(self) -> None:
        times = CaptureTimes(RATE, RemoteClock())
        times.arrived(500, 100.02)
        assert times.captured(500 + RATE, 102.0).reported is None
        times.reported(1000.0, 500, 100.02)
        assert times.captured(500 + RATE, 102.0).reported == pytest.approx(1001.0)

    @pytest.mark.parametrize("remote", [1000.0 - 50, 1000.0 + 50])
    def test_a_report_that_cannot_be_is_not_believed(self, remote: float) -> None:
        clock = RemoteClock()
        times = CaptureTimes(RATE, clock)
        times.arrived(0, 100.0)
        times.reported(1000.0, 0, 100.0)
        times.reported(remote, 100 * RATE, 100.0)
        assert times.captured(RATE, 101.5) == (pytest.approx(101.0), None)

    def test_nothing_is_captured_after_it_came(self) -> None:
        times = CaptureTimes(RATE, RemoteClock())
        times.reported(1000.0, 0, 100.0)
        assert times.captured(RATE, 100.9).at == 100.9
