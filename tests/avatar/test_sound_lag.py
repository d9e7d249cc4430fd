import pytest
from openrois_avatar.sound_lag import LONGEST, MARGIN, REMEMBERED, SoundLag


def test_sound_that_is_sent_ahead_is_not_waited_for() -> None:
    lag = SoundLag()
    assert lag.seconds == 0
    for number in range(100):
        lag.arrived(-0.04, 10 + number / 50)
        assert lag.seconds == 0


def test_late_sound_is_waited_for_at_once_and_a_while() -> None:
    lag = SoundLag()
    for number in range(500):
        late = 0.05 if number == 100 else 0.01
        lag.arrived(late, number / 50)
        remembered = 100 <= number < 100 + 100 * REMEMBERED
        if number < 100 or not remembered:
            assert lag.seconds == pytest.approx(0.01 + MARGIN)
        elif number < 100 + 50 * REMEMBERED:
            assert lag.seconds == pytest.approx(0.05 + MARGIN)


def test_it_never_waits_for_ever() -> None:
    lag = SoundLag()
    lag.arrived(0.9, 1)
    assert lag.seconds == LONGEST


def test_what_was_long_ago_is_forgotten_at_once() -> None:
    lag = SoundLag()
    lag.arrived(0.1, 1)
    lag.arrived(0.01, 1 + 2 * REMEMBERED)
    assert lag.seconds == pytest.approx(0.01 + MARGIN)
