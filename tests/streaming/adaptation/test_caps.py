from openrois_streaming.adaptation.caps import Caps
from openrois_streaming.adaptation.rung import ladder


def test_of_two_limits_the_lower_one_holds() -> None:
    assert Caps().within(Caps()) == Caps()
    one, other = Caps(1_000_000, 640, None, 30.0), Caps(500_000, 1280, 360)
    assert one.within(other) == other.within(one) == Caps(500_000, 640, 360, 30.0)


def test_a_size_is_admitted_if_both_its_sides_fit() -> None:
    rungs = ladder(1280, 720, 30)
    assert [Caps().admits(rung) for rung in rungs] == [True, True, True]
    assert [Caps(width=640).admits(rung) for rung in rungs] == [False, True, True]
    assert [Caps(height=359).admits(rung) for rung in rungs] == [False, False, True]
