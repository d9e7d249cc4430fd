"""Which game engine is run, and the messages about it."""

import pytest
from openrois_avatar.engines.selection import NoGameEngine, choose_game_engine, link_address


def runs() -> tuple[bool, str]:
    return True, ""


def lacks(library: str) -> tuple[bool, str]:
    return False, f"apt install {library}"


def test_the_best_that_runs_is_chosen_and_nothing_is_said() -> None:
    assert choose_game_engine("auto", {"second": runs, "best": runs}, ("best", "second")) == ("best", "")


def test_a_second_best_says_what_the_best_lacks() -> None:
    name, said = choose_game_engine("auto", {"best": lambda: lacks("libbest"), "second": runs}, ("best", "second"))
    assert name == "second"
    assert "apt install libbest" in said
    assert "second" in said


def test_named_engine_is_not_replaced_by_another() -> None:
    assert choose_game_engine("second", {"best": runs, "second": runs}) == ("second", "")
    with pytest.raises(NoGameEngine, match="libbest"):
        choose_game_engine("best", {"best": lambda: lacks("libbest"), "second": runs})


def test_where_none_runs_every_reason_is_given() -> None:
    with pytest.raises(NoGameEngine, match="liba; apt install libb"):
        choose_game_engine("auto", {"a": lambda: lacks("liba"), "b": lambda: lacks("libb")}, ("a", "b"))


def test_engine_outside_of_auto_is_never_chosen_automatically() -> None:
    with pytest.raises(NoGameEngine, match=r"^apt install liba$"):
        choose_game_engine("auto", {"a": lambda: lacks("liba"), "b": runs}, ("a",))
    assert choose_game_engine("b", {"a": runs, "b": runs}, ("a",)) == ("b", "")


def test_an_engine_without_unix_sockets_is_listened_for_on_a_port_of_this_machine() -> None:
    assert link_address("panda3d") is None
    assert link_address("godot") == "tcp:127.0.0.1:0"
