import pytest
from openrois_bench.viewing.observation import Observation, Sightings, missed
from openrois_streaming.source.stamp import NUMBER_MODULUS


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [((), 0), ((7,), 0), ((7, 8, 9), 0), ((7, 9, 13), 4), ((NUMBER_MODULUS - 2, NUMBER_MODULUS - 1, 0, 2), 1)],
)
def test_missing_numbers_are_counted_also_where_they_wrap(numbers: tuple[int, ...], expected: int) -> None:
    assert missed(numbers) == expected


def sightings(**milliseconds: tuple[float, ...]) -> Sightings:
    return Sightings(width=640, height=360, numbers=(4, 5, 7), unreadable=2, milliseconds=milliseconds)


def test_sightings_are_summed_up_in_the_order_of_the_measures() -> None:
    seen = Observation.of("sink", "video/H264", sightings(connect=(90.0, 80.0, 100.0), decoded=(40.0,)))
    assert (seen.pictures, seen.missed, seen.unreadable) == (3, 1, 2)
    assert list(seen.milliseconds) == ["decoded", "connect"]
    assert seen.milliseconds["connect"].p50 == 90.0


def test_observation_without_sightings_is_refused() -> None:
    with pytest.raises(ValueError, match="there are no values to sum up"):
        Observation.of("sink", "video/H264", sightings(decoded=()))
