import itertools
from collections.abc import Iterable

import pytest
from openrois_streaming.source.stamp import NUMBER_MODULUS, Stamp
from openrois_streaming.testing.delays import Delays
from openrois_streaming.testing.pictures import KEPT, SIZES_KEPT, PictureLog, SeenPicture

pytestmark = pytest.mark.extra(name="streaming")

EPOCH = 1_800_000_000.0


def seen(at: float, number: int | None, *, delay: float = 0.05, size: tuple[int, int] = (640, 360)) -> SeenPicture:
    stamp = None if number is None else Stamp.at(number, EPOCH + at - delay)
    return SeenPicture(at, EPOCH + at, *size, stamp)


def log_of(pictures: Iterable[SeenPicture], since: float = 0.0) -> PictureLog:
    log = PictureLog(since)
    for picture in pictures:
        log.add(picture)
    return log


def steadily(count: int, start: float = 0.0) -> list[SeenPicture]:
    return [seen(start + number / 30, number) for number in range(count)]


def test_nothing_was_seen() -> None:
    figures = PictureLog(5.0).figures(7.0)
    assert (figures.seconds, figures.pictures, figures.fps, figures.size, figures.delay) == (2.0, 0, 0.0, None, None)
    assert (figures.freezes, figures.longest_gap) == (0, 0.0)
    assert PictureLog(5.0).figures(5.0).fps == 0.0


def test_all_is_well() -> None:
    log = log_of(steadily(60))
    figures = log.figures(2.0)
    assert figures.fps == 30
    assert (figures.missed, figures.repeated, figures.unreadable, figures.freezes, figures.size_changes) == (0,) * 5
    assert figures.size == (640, 360)
    assert figures.delay == Delays(60, *[pytest.approx(0.05, abs=1e-4)] * 4)  # type: ignore[arg-type]
    assert list(log.sizes) == [(0.0, 640, 360)]
    assert log.count == 60


def test_missing_and_repeated_numbers_are_counted() -> None:
    figures = log_of(seen(at / 30, number) for at, number in enumerate([1, 2, 5, 5, 4, None, 6])).figures(1.0)
    assert (figures.missed, figures.repeated, figures.unreadable) == (2, 2, 1)
    around = [NUMBER_MODULUS - 1, 1]
    assert log_of(seen(at / 30, number) for at, number in enumerate(around)).figures(1.0).missed == 1


def test_key_frames_are_counted_elsewhere() -> None:
    assert PictureLog(0.0).figures(1.0, 3).key_frames == 3


def test_a_freeze_is_a_gap_that_is_long_beside_the_others() -> None:
    pictures = [*steadily(30), seen(29 / 30 + 0.17, 31), seen(29 / 30 + 0.17 + 0.19, 32)]
    figures = log_of(pictures).figures(pictures[-1].at)
    assert (figures.freezes, figures.frozen) == (1, pytest.approx(0.19))
    assert figures.longest_gap == pytest.approx(0.19)


def test_a_slow_stream_does_not_freeze_all_the_time() -> None:
    assert log_of(seen(float(number), number) for number in range(10)).figures(9.0).freezes == 0


def test_a_freeze_that_lasts_is_counted_already() -> None:
    log = log_of(steadily(30))
    figures = log.figures(29 / 30 + 2.0)
    assert (figures.freezes, figures.frozen, figures.longest_gap) == (1, pytest.approx(2.0), pytest.approx(2.0))
    log.add(seen(29 / 30 + 2.5, 100))
    assert log.figures(29 / 30 + 2.5).frozen == pytest.approx(2.5)


def test_one_picture_alone_cannot_freeze() -> None:
    figures = log_of([seen(0, 0)]).figures(9.0)
    assert (figures.freezes, figures.longest_gap) == (0, 9.0)


def test_sizes_that_change() -> None:
    sizes = [(640, 360), (640, 360), (320, 180), (640, 360)]
    log = log_of(seen(float(at), at, size=size) for at, size in enumerate(sizes))
    assert log.figures(4.0).size_changes == 2
    assert list(log.sizes) == [(0.0, 640, 360), (2.0, 320, 180), (3.0, 640, 360)]


def test_a_new_count_forgets_the_old_one_and_not_the_last_picture() -> None:
    log = log_of(steadily(30))
    log.restart(2.0)
    log.add(seen(3.0, 35))
    figures = log.figures(3.1)
    assert (figures.pictures, figures.missed, figures.freezes, figures.frozen) == (1, 5, 1, pytest.approx(1.0))
    assert figures.longest_gap == pytest.approx(1.0), "what came before the count is not part of it"
    assert figures.delay is not None
    assert figures.delay.count == 1
    assert log.count == 31


def test_log_is_bounded() -> None:
    sizes = itertools.cycle([(640, 360), (320, 180)])
    log = log_of(seen(at / 30, at, size=next(sizes)) for at in range(KEPT + 10))
    figures = log.figures(1.0)
    assert figures.pictures == KEPT + 10
    assert figures.delay is not None
    assert figures.delay.count == KEPT
    assert len(log.sizes) == SIZES_KEPT
