"""The battery that a robot reports, and its limit."""

import pytest
from openrois_robots.adapter.battery import BatteryLimit, ReportedBattery


@pytest.mark.parametrize(
    ("percent", "is_low", "refusal"),
    [
        (None, False, ""),
        (20, False, ""),
        (19, True, "the battery is at 19 %; below 20 % only the charger is a goal"),
        (0, True, "the battery is at 0 %; below 20 % only the charger is a goal"),
    ],
)
def test_below_its_limit_goals_are_refused(percent: int | None, is_low: bool, refusal: str) -> None:
    battery = ReportedBattery(BatteryLimit(20.0), percent)
    assert (battery.is_low, battery.refusal) == (is_low, refusal)


@pytest.mark.parametrize("low", [-1.0, 91.0, float("nan")])
def test_a_limit_out_of_bounds_is_refused(low: float) -> None:
    with pytest.raises(ValueError, match=r"battery\.low must be between 0 and 90 per cent"):
        BatteryLimit(low)
