"""The locations and shelves that a robot knows, and targets as applications write them."""

from math import pi

import pytest
from openrois_robots.kachaka.layout import Layout, Location, Shelf, Target

from openrois.errors import BadParameter

CHARGER = Location("L00", "charger", 0.0, 0.0, 0.0, is_charger=True)
KITCHEN = Location("L01", "kitchen", 5.0, 1.0, 0.5)
LAYOUT = Layout((CHARGER, KITCHEN), (Shelf("S01", "tea shelf", 1.0, 1.0, 0.0, "L01"),), "L00")


@pytest.mark.parametrize(
    ("text", "target"),
    [
        ("kitchen", Target("kitchen", KITCHEN, False, 5.0, 1.0, 0.5)),
        ("L01", Target("L01", KITCHEN, False, 5.0, 1.0, 0.5)),
        ("charger", Target("charger", CHARGER, True, 0.0, 0.0, 0.0)),
        ("home", Target("home", is_charger=True)),
        ("1,-2.5", Target("1,-2.5", x=1.0, y=-2.5)),
        ("1, 2, 0.5", Target("1, 2, 0.5", x=1.0, y=2.0, th=0.5)),
    ],
)
def test_a_target_is_read(text: str, target: Target) -> None:
    assert LAYOUT.target(text) == target


def test_a_direction_is_brought_within_half_a_turn() -> None:
    assert LAYOUT.target("0,0,7").th == pytest.approx(7 - 2 * pi)


def test_a_location_called_home_is_that_location() -> None:
    home = Location("L05", "home", 3.0, 3.0, 0.0)
    assert Layout((CHARGER, home), (), "").target("home").location == home


def test_an_id_comes_before_a_name() -> None:
    odd = Location("L09", "L01", 9.0, 9.0, 0.0)
    assert Layout((odd, KITCHEN), (), "").target("L01").location == KITCHEN


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("cellar", "'cellar' is no location of the robot: there is 'home', 'charger', 'kitchen', or x,y or x,y,th"),
        ("1", "'1' is no location of the robot"),
        ("1,x", "'1,x' is no location of the robot"),
        ("1001,0", "'1001,0': expected metres from -1000 to 1000, and radians"),
        ("0,nan", "'0,nan': expected metres"),
    ],
)
def test_what_is_none_is_refused_with_what_there_is(text: str, sentence: str) -> None:
    with pytest.raises(BadParameter) as raised:
        LAYOUT.target(text)
    assert sentence in str(raised.value)


def test_long_lists_are_cut() -> None:
    many = tuple(Location(f"L{number}", f"room {number}", 0, 0, 0) for number in range(30))
    with pytest.raises(BadParameter, match=r"'room 9', \.\.\., or x,y"):
        Layout(many, (), "").target("cellar")


def test_locations_and_shelves_are_found_by_name_and_id() -> None:
    assert LAYOUT.location("kitchen") == LAYOUT.location("L01") == KITCHEN
    assert LAYOUT.shelf("tea shelf") == LAYOUT.shelf("S01")
    assert (LAYOUT.shelf_name("S01"), LAYOUT.shelf_name("S77")) == ("tea shelf", "S77")
    with pytest.raises(BadParameter, match="'wine' is no shelf of the robot: there is 'tea shelf'"):
        LAYOUT.shelf("wine")
    with pytest.raises(BadParameter, match="'wine' is no location of the robot: it knows none"):
        Layout((), (), "").location("wine")


def test_a_name_that_stands_for_several_is_no_target_and_their_ids_are_named() -> None:
    twice = (KITCHEN, Location("L07", "kitchen", 2.0, 2.0, 0.0))
    shelves = (Shelf("S01", "tea", 0.0, 0.0, 0.0, "L01"), Shelf("S02", "tea", 1.0, 0.0, 0.0, "L01"))
    layout = Layout((CHARGER, *twice), shelves, "L00")
    for read in (layout.target, layout.location):
        with pytest.raises(BadParameter, match=r"^'kitchen' is the name of 2 locations: use an id, 'L01' or 'L07'$"):
            read("kitchen")
        assert read("L07")
    with pytest.raises(BadParameter, match=r"^'tea' is the name of 2 shelves: use an id, 'S01' or 'S02'$"):
        layout.shelf("tea")


def test_a_location_without_a_name_is_found_by_its_id_alone() -> None:
    layout = Layout((Location("L09", "", 1.0, 1.0, 0.0),), (), "L09")
    assert layout.location("L09").id == "L09"
    with pytest.raises(BadParameter, match=r"^'' is no location of the robot: there is 'L09'$"):
        layout.location("")
