import pytest
from openrois_streaming.adaptation.thinning import Thinning


@pytest.mark.parametrize(("frame_rate", "left"), [(30, range(12)), (15, range(0, 12, 2)), (10, range(0, 12, 3))])
def test_so_many_are_left_of_a_source_that_is_not_exactly_in_time(frame_rate: float, left: range) -> None:
    thinning = Thinning(frame_rate)
    jolt = [0.0, 0.004, -0.004, 0.002]
    assert [n for n in range(12) if thinning.wants(100 + n / 30 + jolt[n % 4])] == list(left)


def test_after_a_pause_nothing_is_made_up_for() -> None:
    thinning = Thinning(15)
    assert thinning.wants(0.0)
    assert [n for n in range(8) if thinning.wants(20 + n / 30)] == [0, 2, 4, 6]
