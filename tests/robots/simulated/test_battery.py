"""The battery of a simulated robot."""

import pytest
from openrois_robots.simulated.battery import Battery, BatterySettings

pytestmark = pytest.mark.extra(name="robot")

QUICK = BatterySettings(standing=20, driving=10, charging=5)


def after(battery: Battery, minutes: float, effort: float = 0.0, *, on_mat: bool = False) -> Battery:
    for _ in range(round(minutes * 60)):
        battery.advance(1.0, effort, on_mat)
    return battery


@pytest.mark.parametrize(
    ("minutes", "effort", "on_mat", "charge"),
    [(5, 0.0, False, 0.75), (5, 1.0, False, 0.5), (5, 0.5, False, 0.625), (5, 0.0, True, 1.0), (30, 0.0, False, 0.0)],
)
def test_standing_and_driving_take_charge(minutes: float, effort: float, on_mat: bool, charge: float) -> None:
    assert after(Battery(QUICK), minutes, effort, on_mat=on_mat).charge == pytest.approx(charge)


def test_the_mat_charges_until_the_battery_is_full() -> None:
    battery = after(Battery(BatterySettings(charge=0.5, charging=5)), 1, on_mat=True)
    assert (battery.charge, battery.is_charging) == (pytest.approx(0.7), True)
    assert not after(battery, 2, on_mat=True).is_charging
    assert battery.charge == 1.0


@pytest.mark.parametrize(
    ("charge", "percent", "is_low", "refusal"),
    [
        (1.0, 100, False, ""),
        (0.2, 20, False, ""),
        (0.18, 18, True, "the battery is at 18 %; below 20 % only the dock is a goal"),
        (0.001, 1, True, "the battery is at 1 %; below 20 % only the dock is a goal"),
        (0.0, 0, True, "the battery is empty; push the robot to its dock, and wait until it is charged"),
    ],
)
def test_a_low_battery_says_what_is_refused(charge: float, percent: int, is_low: bool, refusal: str) -> None:
    battery = Battery(BatterySettings(charge=charge))
    assert (battery.percent, battery.is_low, battery.refusal) == (percent, is_low, refusal)


def test_a_battery_that_was_empty_has_to_be_charged_by_a_twentieth() -> None:
    battery = after(Battery(QUICK), 25)
    assert battery.is_empty
    after(battery, 0.2, on_mat=True)
    assert (battery.percent, battery.is_empty) == (4, True)
    after(battery, 0.1, on_mat=True)
    assert not battery.is_empty
    assert battery.is_low


def test_without_a_limit_a_battery_is_low_when_it_is_empty() -> None:
    battery = after(Battery(BatterySettings(low=0.0, charge=0.01, standing=20, driving=10)), 1)
    assert battery.is_empty
    assert battery.is_low


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"charge": 1.1}, "battery.charge must be between 0 and 1, not 1.1"),
        ({"low": -0.1}, "battery.low must be between 0 and 0.9, not -0.1"),
        ({"charging": 0.0}, "battery.charging must be between 0.1 and 100000 minutes, not 0"),
        ({"driving": float("nan")}, "battery.driving must be between 0.1 and 100000 minutes, not nan"),
        ({"driving": 500.0}, "battery.driving must not be longer than battery.standing"),
    ],
)
def test_impossible_batteries_are_refused(settings: dict[str, float], why: str) -> None:
    with pytest.raises(ValueError, match=why.replace(".", r"\.")):
        BatterySettings(**settings)
