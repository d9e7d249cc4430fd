from itertools import pairwise
from math import cos, hypot, sin

import pytest
from openrois_avatar.engines.room.plan import HOME, ROOM, Furniture, Plan, box
from openrois_avatar.engines.room.visitor import PLACES, Visitor
from openrois_avatar.engines.room.walking import Pace
from openrois_avatar.link.messages import Place, Thing, Waypoint

FRAME = 1 / 30


def life(seed: int, seconds: float, other: Place = HOME) -> list[Place]:
    visitor, places = Visitor(ROOM, 0.0, seed), []
    for number in range(round(seconds / FRAME)):
        visitor.advance(number * FRAME, other)
        places.append(visitor.place)
    return places


def test_visitor_walks_slowly_from_place_to_place_and_stays_there() -> None:
    places = life(1, 180.0)
    stays = [place for place, later in zip(places[:-30], places[30:], strict=True) if place == later]
    known = {(place.x, place.y) for place in PLACES}
    assert {(place.x, place.y) for place in stays} <= known
    assert len({(place.x, place.y) for place in stays}) >= 4
    steps = [hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(places)]
    assert max(steps) <= 0.6 * FRAME + 0.006
    assert 0.2 < sum(step > 0 for step in steps) / len(steps) < 0.7


def test_one_seed_gives_one_sequence() -> None:
    assert life(7, 40.0) == life(7, 40.0)
    assert life(7, 40.0) != life(8, 40.0)


def test_visitor_keeps_away_from_furniture_and_from_the_figures_first_place() -> None:
    for place in life(3, 180.0):
        assert ROOM.fits(place.x, place.y, 0.2)
        assert hypot(place.x - HOME.x, place.y - HOME.y) > 0.75


@pytest.mark.parametrize("place", PLACES)
def test_every_place_has_a_way_to_another(place: Waypoint) -> None:
    there = (place.x, place.y)
    others = [(other.x, other.y) for other in PLACES if other is not place]
    assert any(ROOM.is_clear(there, other, 0.25) for other in others)


def test_visitor_makes_room_for_a_close_figure() -> None:
    visitor = Visitor(ROOM, 0.0)
    start = visitor.place
    close = Place(start.x - 0.3, start.y - 0.5, 1.0)
    for number in range(60):
        visitor.advance(number * FRAME, close)
    assert visitor.pace != Pace()
    for number in range(60, 200):
        visitor.advance(number * FRAME, close)
    assert hypot(visitor.place.x - close.x, visitor.place.y - close.y) > 1.0


def test_visitor_waits_for_a_figure_in_its_way_and_then_goes_elsewhere() -> None:
    visitor, time = Visitor(ROOM, 0.0), 0.0
    while hypot(visitor.pace.ahead, visitor.pace.left) < 0.5:
        time += FRAME
        visitor.advance(time, HOME)
    here, pace = visitor.place, visitor.pace
    before = Place(here.x + 0.7 * cos(here.th), here.y + 0.7 * sin(here.th), 0.0)
    assert pace.ahead > 0.4
    stood = 0
    for _ in range(400):
        time += FRAME
        visitor.advance(time, before)
        assert hypot(visitor.place.x - before.x, visitor.place.y - before.y) > 0.4
        stood += visitor.pace == Pace()
    assert stood > 30
    assert hypot(visitor.place.x - here.x, visitor.place.y - here.y) > 0.5


def test_enclosed_visitor_stays() -> None:
    wall = Furniture("wall", 0.0, 2.0, box(0.0, 2.0, 3.0, 4.0), 2.0)
    upper = Furniture("shelf", 2.2, 1.6, box(2.2, 1.6, 1.5, 0.3), 2.0)
    visitor = Visitor(Plan(ROOM.outline, (wall, upper)), 0.0)
    here = visitor.place
    for number in range(900):
        visitor.advance(number * FRAME, HOME)
    assert visitor.place == here


def test_visitor_is_a_person() -> None:
    visitor = Visitor(ROOM, 0.0)
    assert visitor.thing == Thing("visitor", "person", visitor.place.x, visitor.place.y, visitor.place.th, "visitor")
