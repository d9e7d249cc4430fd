import numpy as np

from tools.sculpt.hair import locks


def test_both_sides_of_the_hair_meet_at_the_hair_line() -> None:
    made = locks()
    first = [made[10][0], made[len(made) // 2 + 10][0]]
    falling, tucked = (grid[0].mean(axis=0) for grid in first)
    assert np.linalg.norm(falling - tucked) < 0.1
    # The scalp ends above, so that its edge is under them.
    assert falling[2] < 1.02
    assert tucked[2] < 1.02
