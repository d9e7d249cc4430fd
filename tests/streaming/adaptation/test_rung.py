import itertools

import pytest
from openrois_streaming.adaptation.rung import MAX_BITRATE, MIN_BITRATE, Rung, Thinning, every_for, ladder


def test_the_sizes_of_a_source_are_halved_as_long_as_they_are_of_use() -> None:
    sizes = {
        (1280, 720): [(1280, 720), (640, 360), (320, 180)],
        (640, 360): [(640, 360), (320, 180)],
        (1920, 1080): [(1920, 1080), (960, 540), (480, 270)],
        (3840, 2160): [(3840, 2160), (1920, 1080), (960, 540), (480, 270)],
        (7680, 4320): [(7680, 4320), (3840, 2160), (1920, 1080), (960, 540)],
        (720, 1280): [(720, 1280), (360, 640), (180, 320)],
        (320, 240): [(320, 240)],
        (160, 90): [(160, 90)],
    }
    for source, expected in sizes.items():
        assert [(rung.width, rung.height) for rung in ladder(*source, 30)] == expected
    assert [(rung.width, rung.height) for rung in ladder(855, 481, 30)] == [(854, 480), (426, 240)]


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (640, 360), (3840, 2160)])
@pytest.mark.parametrize("frame_rate", [15.0, 30.0, 60.0])
def test_the_bit_rates_of_neighbours_overlap_and_the_lowest_goes_to_the_bottom(
    size: tuple[int, int], frame_rate: float
) -> None:
    rungs = ladder(*size, frame_rate)
    for higher, lower in itertools.pairwise(rungs):
        assert lower.min_bitrate < higher.min_bitrate < lower.max_bitrate < higher.max_bitrate <= MAX_BITRATE
        assert higher.halvings == lower.halvings - 1
    assert rungs[-1].min_bitrate == MIN_BITRATE


def test_720p_at_30_has_2500_kbit_and_twice_the_pace_has_less_than_twice_of_it() -> None:
    assert ladder(1280, 720, 30)[0] == Rung(1280, 720, 30.0, 700_000, 2_500_000)
    assert 2_500_000 < ladder(1280, 720, 60)[0].max_bitrate < 5_000_000
    assert 4_000_000 < ladder(1920, 1080, 30)[0].max_bitrate < 2.25 * 2_500_000


def test_a_limit_holds_for_all_rungs_and_leaves_something() -> None:
    assert [rung.max_bitrate for rung in ladder(1280, 720, 30, max_bitrate=400_000)] == [400_000, 400_000, 312_500]
    assert {rung.max_bitrate for rung in ladder(1280, 720, 30, max_bitrate=1)} == {MIN_BITRATE}


@pytest.mark.parametrize(
    ("wanted", "every"), [(None, 1), (60.0, 1), (30.0, 1), (29.97, 1), (29.0, 2), (15.0, 2), (10.0, 3), (1.0, 8)]
)
def test_of_so_many_pictures_one_is_sent(wanted: float | None, every: int) -> None:
    assert every_for(30.0, wanted) == every
    assert ladder(1280, 720, 30.0, every=every)[0].frame_rate == 30.0 / every


@pytest.mark.parametrize(("frame_rate", "left"), [(30, range(12)), (15, range(0, 12, 2)), (10, range(0, 12, 3))])
def test_so_many_are_left_of_a_source_that_is_not_exactly_in_time(frame_rate: float, left: range) -> None:
    thinning = Thinning(frame_rate)
    jolt = [0.0, 0.004, -0.004, 0.002]
    assert [n for n in range(12) if thinning.wants(100 + n / 30 + jolt[n % 4])] == list(left)


def test_after_a_pause_nothing_is_made_up_for() -> None:
    thinning = Thinning(15)
    assert thinning.wants(0.0)
    assert [n for n in range(8) if thinning.wants(20 + n / 30)] == [0, 2, 4, 6]
