from openrois_streaming.receive.jitter import LONGEST_DELAY, WINDOW, TargetDelay


def fed(delays: list[float], *, begin: int = 0, target: TargetDelay | None = None) -> TargetDelay:
    target = target or TargetDelay()
    for number, delay in enumerate(delays, begin):
        target.arrived(number * 0.02, 100 + number * 0.02 + delay)
    return target


def test_a_quiet_path_needs_next_to_nothing() -> None:
    target = fed([0.03] * 100)
    assert target.seconds < 0.005
    assert abs(target.base - 100.03) < 1e-9


def test_nothing_has_come() -> None:
    assert TargetDelay().base == 0.0


def test_nearly_all_packets_are_in_time() -> None:
    target = fed([0.04 if number % 10 == 0 else 0.0 for number in range(100)])
    assert 0.04 <= target.seconds < 0.045


def test_single_late_packet_is_not_awaited() -> None:
    assert fed([0.1 if number == 50 else 0.0 for number in range(100)]).seconds < 0.005


def test_old_delays_are_dropped() -> None:
    target = fed([0.2 if number % 2 else 0.0 for number in range(100)])
    assert target.seconds > 0.2
    assert fed([0.0] * round(WINDOW / 0.02 + 20), begin=100, target=target).seconds < 0.005


def test_a_path_that_stands_still_once_is_not_waited_for() -> None:
    stall = [0.02 * (65 - number) if 50 <= number < 65 else 0.0 for number in range(100)]
    assert fed(stall).seconds < 0.005


def test_a_path_that_stands_still_again_and_again_is() -> None:
    stalls = [0.02 * (15 - number % 20) if number % 20 < 15 else 0.0 for number in range(200)]
    assert fed(stalls).seconds > 0.25


def test_delays_before_a_long_pause_are_dropped() -> None:
    target = fed([0.2 if number % 2 else 0.0 for number in range(100)])
    assert fed([0.0], begin=1000, target=target).seconds < 0.005


def test_there_is_a_bound() -> None:
    assert fed([1.5 * (number % 2) for number in range(100)]).seconds == LONGEST_DELAY


def test_another_time_is_another_beginning() -> None:
    target = fed([0.0] * 50)
    assert target.arrived(1000.0, 101.0)
    assert not target.arrived(1000.02, 101.02)
    assert target.seconds < 0.005
