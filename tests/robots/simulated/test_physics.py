"""The robot's body among walls: Bullet keeps it out of them."""

from math import cos, hypot, sin

import pytest
from openrois_body.messages import Place
from openrois_robots.simulated.physics import RADIUS, STEP, Physics
from openrois_robots.simulated.world.plan import APARTMENT

pytestmark = pytest.mark.extra(name="robot")


def pushed(physics: Physics, x: float, y: float, seconds: float) -> tuple[float, float]:
    for _ in range(round(seconds / STEP)):
        physics.step(x, y)
    return physics.at


def test_it_goes_as_it_is_pushed() -> None:
    physics = Physics(APARTMENT)
    assert pushed(physics, 0.5, 0.25, 2.0) == pytest.approx((-3.0, -2.0), abs=0.001)
    assert pushed(physics, 0.0, 0.0, 2.0) == pytest.approx((-3.0, -2.0), abs=0.001)


@pytest.mark.parametrize(
    ("start", "direction", "wall"),
    [
        ((-4.0, -2.5), (-1.0, 0.0), -5.0),
        ((4.0, 1.0), (1.0, 0.0), 5.0),
        ((-1.0, 0.0), (1.0, 0.0), -0.06),
        ((-1.6, 1.6), (-1.0, 0.0), -2.55),
    ],
)
def test_walls_and_furniture_hold_it(start: tuple[float, float], direction: tuple[float, float], wall: float) -> None:
    physics = Physics(APARTMENT)
    physics.put(*start)
    x, _ = pushed(physics, 2.0 * direction[0], 2.0 * direction[1], 10.0)
    assert x == pytest.approx(wall - direction[0] * RADIUS, abs=0.06)


@pytest.mark.parametrize("number", range(8))
def test_nothing_pushes_it_out_of_the_building(number: int) -> None:
    physics = Physics(APARTMENT)
    physics.put(-2.0, -0.6)
    x, y = pushed(physics, 2.0 * cos(number), 2.0 * sin(number), 20.0)
    assert APARTMENT.left + RADIUS - 0.05 < x < APARTMENT.right - RADIUS + 0.05
    assert APARTMENT.bottom + RADIUS - 0.05 < y < APARTMENT.top - RADIUS + 0.05


def test_the_room_ahead_ends_at_what_is_in_the_way() -> None:
    physics = Physics(APARTMENT)
    physics.put(-1.0, 0.0)
    assert physics.room(1.0, 0.0, 2.0) == pytest.approx(1.0 - 0.06 - RADIUS, abs=0.06)
    assert physics.room(-1.0, 0.0, 0.5) == 0.5
    assert physics.room(0.0, 0.0, 0.5) == 0.5


def test_along_a_wall_the_way_is_free() -> None:
    physics = Physics(APARTMENT)
    physics.put(-0.06 - RADIUS - 0.02, 0.0)
    assert physics.room(0.0, 1.0, 0.5) == 0.5
    _, y = pushed(physics, 0.1, 0.5, 1.0)
    assert y == pytest.approx(0.5, abs=0.02), "it slides along"


def test_a_visitor_is_in_the_way() -> None:
    physics = Physics(APARTMENT)
    physics.put(-2.0, -0.6)
    assert physics.room(1.0, 0.0, 1.0) == 1.0
    physics.place_visitor(Place(-1.2, -0.6, 0.0))
    physics.step(0.0, 0.0)
    assert physics.room(1.0, 0.0, 1.0) < 0.5
    physics.place_visitor(Place(-1.2, 0.6, 0.0))
    physics.step(0.0, 0.0)
    assert physics.room(1.0, 0.0, 1.0) == 1.0


def test_a_visitor_is_not_pushed_away() -> None:
    physics = Physics(APARTMENT)
    physics.put(-2.0, -0.6)
    physics.place_visitor(Place(-1.2, -0.6, 0.0))
    x, y = pushed(physics, 1.0, 0.0, 3.0)
    assert hypot(x + 1.2, y + 0.6) > 0.35
