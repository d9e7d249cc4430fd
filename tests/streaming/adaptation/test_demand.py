import pytest
from openrois_streaming.adaptation.demand import LOWEST, MIDDLE, TOP, CoarseRate, Demands
from openrois_streaming.adaptation.rung import Rung

RUNG = Rung(640, 360, 30.0, 200_000, 1_000_000)


@pytest.mark.parametrize(
    ("tolerance", "demands", "bitrate"),
    [
        (TOP, [], 200_000),
        (TOP, [600_000], 600_000),
        (TOP, [5_000_000], 1_000_000),
        (TOP, [10_000], 200_000),
        (TOP, [1_000_000, 950_000], 950_000),
        (TOP, [1_000_000, 500_000], 1_000_000),
        (MIDDLE, [1_000_000, 700_000, 300_000], 700_000),
        (LOWEST, [1_000_000, 700_000, 300_000], 300_000),
    ],
)
def test_the_rate_is_the_lowest_demand_that_is_close_to_the_highest(
    tolerance: float, demands: list[float], bitrate: int
) -> None:
    shared = Demands(RUNG, tolerance)
    for viewer, demand in enumerate(demands):
        shared.put(viewer, demand)
    assert (shared.bitrate, shared.viewers) == (bitrate, len(demands))


def test_new_viewer_needs_the_least_demand_of_the_others() -> None:
    shared = Demands(RUNG, TOP)
    assert shared.least("me") == 200_000
    shared.put("me", 900_000)
    assert shared.least("me") == 200_000, "its own demand is not in its way"
    shared.put("other", 5_000_000)
    assert shared.least("me") == pytest.approx(TOP * 1_000_000)
    assert shared.least("other") == pytest.approx(TOP * 900_000)
    shared.drop("other")
    shared.drop("other")
    assert shared.least("me") == 200_000


def test_a_source_of_another_size_has_other_bounds() -> None:
    shared = Demands(RUNG, TOP)
    assert not shared.suit(RUNG, TOP)
    shared.put("me", 5_000_000)
    assert shared.suit(Rung(1280, 720, 30.0, 700_000, 2_500_000), TOP)
    assert shared.bitrate == 2_500_000


def test_a_coarse_rate_goes_down_at_once_and_up_after_a_while() -> None:
    rate = CoarseRate()
    assert rate.follow(900_000, RUNG, 0.0) == 800_000
    assert rate.follow(850_000, RUNG, 1.0) == 800_000
    assert rate.follow(799_999, RUNG, 1.1) == 640_000
    assert rate.follow(900_000, RUNG, 2.0) == 640_000
    assert rate.follow(700_000, RUNG, 3.0) == 640_000, "it was not possible all the time"
    assert rate.follow(900_000, RUNG, 5.0) == 640_000
    assert rate.follow(900_000, RUNG, 8.9) == 640_000
    assert rate.follow(900_000, RUNG, 9.0) == 800_000
    assert rate.follow(100, RUNG, 9.1) == RUNG.min_bitrate
