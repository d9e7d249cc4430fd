from openrois.engine.lost_components import LostComponents


def test_what_is_lost_is_known_until_it_is_found() -> None:
    lost = LostComponents()
    lost.lose(["a/lamp", "a/door"])
    assert "a/lamp" in lost
    lost.found(["a/lamp", "b/lamp"])
    assert "a/lamp" not in lost
    assert "a/door" in lost


def test_of_too_many_the_first_are_forgotten() -> None:
    lost = LostComponents(2)
    lost.lose(["a/1", "a/2"])
    lost.lose(["a/1"])
    lost.lose(["a/3"])
    assert ["a/1" in lost, "a/2" in lost, "a/3" in lost, len(lost)] == [True, False, True, 2]
