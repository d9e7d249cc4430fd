"""What is said of pictures, from their moments alone."""

from openrois_avatar.check.finding import Outcome
from openrois_avatar.check.media_checks import check_pictures
from openrois_avatar.check.record import Picture

from tests.support.avatar_link import HELLO


def rate(arrivals: list[float], moments: list[float]) -> tuple[Outcome, str]:
    """What is said of how many there are, when 30 a second were announced."""
    seen = [
        Picture(at, claimed, number, (4, 2), "bgra")
        for number, (at, claimed) in enumerate(zip(arrivals, moments, strict=True))
    ]
    (found,) = (each for each in check_pictures(HELLO, seen, paused=False, opened=0.0) if each.check == "pictures")
    return found.outcome, found.seen


def each(number: float, seconds: float = 2.0) -> list[float]:
    """So many moments a second."""
    return [count / number for count in range(round(number * seconds))]


def test_too_few_and_too_many() -> None:
    assert rate(each(30), each(30)) == (Outcome.PASSED, "30.0 a second, 30 announced")
    assert rate(each(10), each(10)) == (Outcome.FAILED, "10.0 a second, 30 announced")
    assert rate(each(50), each(50)) == (Outcome.FAILED, "50.0 a second, 30 announced")


def test_late_check_accepts_many_pictures_at_once() -> None:
    assert rate([max(moment, 1.2) for moment in each(30)], each(30)) == (
        Outcome.PASSED,
        "30.0 a second, 30 announced",
    )


def test_one_wrong_moment_neither_hides_nor_makes_a_rate() -> None:
    assert rate(each(30), [-5000.0, *each(30)[1:]]) == (Outcome.PASSED, "30.0 a second, 30 announced")
    assert rate(each(50), [-5000.0, *each(50)[1:]]) == (Outcome.FAILED, "50.0 a second, 30 announced")
    assert rate(each(50), [*each(50)[:-1], 5000.0]) == (Outcome.FAILED, "50.0 a second, 30 announced")
    assert rate(each(10), [-5000.0, *each(10)[1:]]) == (Outcome.FAILED, "10.0 a second, 30 announced")


def test_rate_of_arrival_is_reported_if_it_is_right() -> None:
    slower = [moment * 1.2 - 0.4 for moment in each(40)]
    assert rate(each(40), slower) == (Outcome.PASSED, "40.0 a second, 30 announced")


def test_very_late_check_judges_only_believed_pictures() -> None:
    assert rate([max(moment, 4.0) for moment in each(30, 6.0)], each(30, 6.0)) == (
        Outcome.PASSED,
        "30.0 a second, 30 announced",
    )


def test_pictures_without_timestamps_are_counted_by_arrival() -> None:
    assert rate(each(50), [0.0] * 100)[0] is Outcome.FAILED
