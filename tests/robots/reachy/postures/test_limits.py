"""The highest speeds of the configuration."""

import pytest
from openrois_robots.reachy.postures.limits import MotionLimits


@pytest.mark.parametrize("name", ["head", "body", "antennas"])
@pytest.mark.parametrize("value", [0.05, 2.5, float("nan")])
def test_a_speed_that_may_jump_or_never_arrives_is_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=rf"motion\.{name} must be between 0.1 and \d"):
        MotionLimits(**{name: value})


def test_slower_is_allowed() -> None:
    assert MotionLimits(0.1, 0.1, 0.1).head == 0.1
