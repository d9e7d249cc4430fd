from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.receive.sequence import Unwrapped


def test_the_first_is_taken_as_it_is() -> None:
    assert Unwrapped(16)(5) % 65536 == 5


def test_numbers_go_on_over_the_wrap() -> None:
    unwrapped = Unwrapped(16)
    first = unwrapped(65534)
    assert [unwrapped(each) - first for each in (65535, 0, 2, 1)] == [1, 2, 4, 3]


def test_what_is_older_stays_older() -> None:
    unwrapped = Unwrapped(16)
    first = unwrapped(1)
    assert unwrapped(65535) == first - 2
    assert unwrapped(2) == first + 1


def test_looking_does_not_move_it() -> None:
    unwrapped = Unwrapped(16)
    assert unwrapped.nearest(7) == unwrapped(7)
    unwrapped.nearest(30_000)
    assert unwrapped(40_000) - unwrapped(7) == 40_000 - 7 - 65536


@given(st.lists(st.integers(-30_000, 30_000)), st.integers(0, 65535))
def test_steps_of_less_than_half_are_followed(steps: list[int], start: int) -> None:
    unwrapped = Unwrapped(16)
    number = unwrapped(start)
    for step in steps:
        newest = number
        number = max(number, number + step)
        assert unwrapped(newest + step & 0xFFFF) == newest + step
