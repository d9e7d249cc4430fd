"""The plan of the rooms: what stands in them is in the rooms, and every place can be reached."""

from itertools import pairwise
from math import dist

import numpy as np
import pytest
from openrois_body.components.follow import _APART as FOLLOWED
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import plan as way_to
from openrois_body.motion.wayfinding import BODY
from openrois_robots.simulated.physics import RADIUS
from openrois_robots.simulated.world.plan import APARTMENT, PERSON_RADIUS

pytestmark = pytest.mark.extra(name="robot")

GROUND = Ground(APARTMENT.floor, BODY)
START = APARTMENT.start.x, APARTMENT.start.y


def test_the_planner_keeps_more_room_than_the_robot_needs() -> None:
    assert RADIUS < BODY


def test_everything_stands_within_the_building() -> None:
    for thing in APARTMENT.things:
        assert APARTMENT.left < thing.x < APARTMENT.right
        assert APARTMENT.bottom < thing.y < APARTMENT.top
    for piece in APARTMENT.furniture:
        for x, y in piece.outline:
            assert APARTMENT.left <= x <= APARTMENT.right, piece.name
            assert APARTMENT.bottom <= y <= APARTMENT.top, piece.name


def test_names_are_unique() -> None:
    names = [*(thing.name for thing in APARTMENT.things), APARTMENT.visitor.name]
    assert len(set(names)) == len(names)


def test_the_map_lacks_what_is_not_mapped() -> None:
    lacking = [piece for piece in APARTMENT.furniture if not piece.is_mapped]
    assert [piece.name for piece in lacking] == ["parcel"]
    assert "parcel" not in {thing.name for thing in APARTMENT.things}
    assert GROUND.clear_at((lacking[0].x, lacking[0].y)), "so a goal can be set there"


@pytest.mark.parametrize("goal", [(2.0, 1.5), (1.2, -1.3), (-1.5, 2.7), (4.4, 2.4), (-4.5, -0.5), APARTMENT.round[0]])
def test_every_room_can_be_reached(goal: tuple[float, float]) -> None:
    assert way_to(GROUND, START, 0.0, goal, "distance")[-1] == goal


def test_the_visitor_can_go_its_round() -> None:
    ground = Ground(APARTMENT.floor, PERSON_RADIUS)
    begin = APARTMENT.visitor.place
    for here, there in pairwise([(begin.x, begin.y), *APARTMENT.round, APARTMENT.round[0]]):
        assert ground.clear_at(here)
        assert ground.open(np.asarray(here), np.asarray([there]))[0]


def test_the_mat_charges_where_navigation_to_it_ends() -> None:
    assert APARTMENT.mat.holds(*START)
    assert APARTMENT.mat.holds(APARTMENT.mat.x + 0.8, APARTMENT.mat.y), "navigation ends within 0.8 m of a thing"
    assert not APARTMENT.mat.holds(APARTMENT.mat.x + 1.0, APARTMENT.mat.y)


def test_persons_stand_where_a_robot_gets_near_enough() -> None:
    for person in APARTMENT.persons:
        centre = np.asarray((person.place.x, person.place.y))
        clear = GROUND.nearest_clear(centre)
        assert clear is not None
        assert dist(clear, centre) < FOLLOWED
