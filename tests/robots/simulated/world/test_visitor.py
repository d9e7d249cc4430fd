"""The person who walks about."""

from math import dist, pi

import pytest
from openrois_body.messages import Place
from openrois_robots.simulated.world.visitor import Visitor

STEP = 0.05
FAR = (50.0, 50.0)


def walked(visitor: Visitor, seconds: float, robot: tuple[float, float] = FAR) -> list[Place]:
    places = []
    for _ in range(round(seconds / STEP)):
        visitor.advance(STEP, robot)
        places.append(visitor.place)
    return places


def test_it_stands_and_then_goes_from_point_to_point() -> None:
    visitor = Visitor(Place(0, 0, 1.0), ((3, 0), (3, 3)))
    assert set(walked(visitor, 2.9)) == {Place(0, 0, 1.0)}
    places = walked(visitor, 14.5)
    assert Place(3, 0, 0.0) in places
    assert dist((places[-1].x, places[-1].y), (3, 3)) < 0.1
    assert places[-1].th == pytest.approx(pi / 2)
    assert visitor.walked == pytest.approx(6, abs=0.1)
    assert walked(visitor, 8)[-1].y < 1, "and round again"


def test_it_waits_for_a_robot_ahead() -> None:
    visitor = Visitor(Place(0, 0, 0), ((3, 0), (0, 0)))
    assert walked(visitor, 10, robot=(1.5, 0.0))[-1].x == pytest.approx(0.75, abs=0.05)
    assert walked(visitor, 5)[-1].x == pytest.approx(3, abs=0.05)


def test_it_does_not_wait_for_a_robot_behind() -> None:
    visitor = Visitor(Place(0, 0, 0), ((3, 0), (0, 0)))
    assert walked(visitor, 8.5, robot=(-0.5, 0.0))[-1].x == pytest.approx(3, abs=0.05)
