"""Pictures of the rooms: what the camera is turned to is seen, and the shared finder of faces finds the persons."""

from collections.abc import Iterator
from math import cos, radians, sin

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.messages import Place
from openrois_body.vision.box import place_of
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.view import View as Photo
from openrois_robots.simulated.camera import SIZE
from openrois_robots.simulated.drawing.renderer import Renderer
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.world.plan import APARTMENT, Person
from openrois_streaming.source.source import RawVideo

pytestmark = pytest.mark.extra(name="robot")

WIDTH, HEIGHT = SIZE
DOWN = -0.1
"""Radians by which the camera of the robot looks up."""


@pytest.fixture(scope="module")
def renderer() -> Iterator[Renderer]:
    drawing = Renderer(APARTMENT, WIDTH, HEIGHT)
    yield drawing
    drawing.close()


def before(person: Person, metres: float, degrees: float = 0.0) -> Place:
    """Return a place from which a person is looked at, so many degrees beside where it looks."""
    angle = person.place.th + radians(degrees)
    return Place(person.place.x + metres * cos(angle), person.place.y + metres * sin(angle), angle + np.pi)


def faces(picture: NDArray[np.uint8]) -> list[tuple[float, float]]:
    """Return how far to the right and ahead of the camera the shared finder sees faces, in metres."""
    found = CascadeFinder().find(Photo(RawVideo(picture, "bgra", WIDTH, HEIGHT, 0, 0.0)), ())
    places = [place_of(face.box, WIDTH / HEIGHT) for face in found]
    return [(place.x, place.y) for place in places]


def test_a_picture_is_an_array_of_its_own(renderer: Renderer) -> None:
    first = renderer.draw(View(APARTMENT.start))
    kept = first.copy()
    second = renderer.draw(View(Place(-4, -2.5, 3.0)))
    assert first.shape == second.shape == (HEIGHT, WIDTH, 4)
    assert first.dtype == np.uint8
    assert np.array_equal(first, kept)
    assert not np.array_equal(first, second)
    assert np.array_equal(renderer.draw(View(APARTMENT.start)), kept), "the same view is the same picture"


def test_the_floor_is_below_and_the_ceiling_above(renderer: Renderer) -> None:
    picture = renderer.draw(View(Place(-4.6, -3.2, 0.8), DOWN)).astype(int)
    ceiling, floor = picture[3, 200:440, :3].mean(axis=0), picture[-3, 200:440, :3].mean(axis=0)
    assert ceiling.min() > 170
    assert floor[2] > floor[0] + 20, "boards are brown"


def test_what_is_on_the_left_is_on_the_left(renderer: Renderer) -> None:
    reader = APARTMENT.persons[0]
    at = before(reader, 2.0)
    shirt = []
    for aside in (-0.2, 0.2):
        picture = renderer.draw(View(Place(at.x, at.y, at.th + aside))).astype(int)
        is_red = (picture[..., 2] > 100) & (picture[..., 2] > 2 * picture[..., 1])
        shirt.append(np.nonzero(is_red)[1].mean() / WIDTH)
    assert shirt[0] < 0.45 < 0.55 < shirt[1], "turned to its right it sees the person on its left"


def test_looking_down_shows_more_floor(renderer: Renderer) -> None:
    level, down = (renderer.draw(View(Place(-2.2, -2.4, 1.6), tilt)).astype(int) for tilt in (0.0, -0.4))
    brown = [((each[..., 2] - each[..., 0]) > 40).mean() for each in (level, down)]
    assert brown[1] > brown[0] + 0.1


@pytest.mark.parametrize("name", [person.name for person in APARTMENT.persons])
@pytest.mark.parametrize("metres", [1.2, 1.5, 2.0])
def test_the_shared_finder_sees_the_face_of_a_person(renderer: Renderer, name: str, metres: float) -> None:
    person = next(each for each in APARTMENT.persons if each.name == name)
    at = before(person, metres)
    seen = []
    for turn in (-0.06, -0.03, 0.0, 0.03, 0.06):
        found = faces(renderer.draw(View(Place(at.x, at.y, at.th + turn), DOWN)))
        seen += [ahead for right, ahead in found if abs(right - metres * turn) < 0.2]
    assert len(seen) >= 3, "a finder misses some"
    assert np.median(seen) == pytest.approx(metres, rel=0.4), "an estimate from its size"


def test_it_sees_no_face_from_behind_or_where_there_is_none(renderer: Renderer) -> None:
    assert faces(renderer.draw(View(before(APARTMENT.persons[0], 1.5, 180)))) == []
    assert faces(renderer.draw(View(Place(-4.0, -0.5, np.pi)))) == []


def test_a_visitor_is_drawn_where_it_is(renderer: Renderer) -> None:
    empty = renderer.draw(View(Place(-3.6, -1.0, 0.0), DOWN)).astype(int)
    there = renderer.draw(View(Place(-3.6, -1.0, 0.0), DOWN, visitor=Place(-1.5, -1.0, np.pi))).astype(int)
    changed = np.abs(there - empty)[..., :3].max(axis=2) > 20
    rows, columns = np.nonzero(changed)
    assert columns.mean() / WIDTH == pytest.approx(0.5, abs=0.05)
    assert 0.02 < changed.mean() < 0.3
    assert len(faces(there.astype(np.uint8))) == 1, "and looks at the robot"
    step = renderer.draw(View(Place(-3.6, -1.0, 0.0), DOWN, visitor=Place(-1.5, -1.0, np.pi), step=0.175)).astype(int)
    moved, _ = np.nonzero(np.abs(step - there)[..., :3].max(axis=2) > 20)
    assert moved.min() > rows.min() + 60, "its legs move"
