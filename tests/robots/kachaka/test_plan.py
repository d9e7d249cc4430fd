"""The robot's map as a smaller picture, and as a floor."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_robots.kachaka.plan import floor_of, scaled
from openrois_robots.kachaka.simulator.house import HOUSE

from openrois.adapter import ComponentFailed


def png(pixels: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".png", pixels)[1].tobytes()


def pixels(data: bytes) -> NDArray[np.uint8]:
    return np.asarray(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE), np.uint8)


def test_thin_walls_stay_when_a_map_is_made_smaller() -> None:
    wall = np.full((1000, 1500), 255, np.uint8)
    wall[500, :] = 0
    made = scaled(png(wall), 0.05)
    assert (made.width, made.height, made.resolution) == (500, 334, pytest.approx(0.15))
    assert (pixels(made.png) == 0).any(axis=0).all(), "it goes from side to side"


def test_the_corner_at_the_bottom_on_the_left_stays_where_it_is() -> None:
    corner = np.full((1003, 1003), 255, np.uint8)
    corner[-1, 0] = 0
    assert pixels(scaled(png(corner), 0.05).png)[-1, 0] == 0


@pytest.mark.parametrize("data", [b"", b"no picture", png(np.full((9, 9), 255, np.uint8))[:30]])
def test_what_is_no_picture_is_refused(data: bytes) -> None:
    with pytest.raises(ComponentFailed, match="the robot's map is no picture that can be read: "):
        scaled(data, 0.05)


@pytest.mark.parametrize("resolution", [0.0, -0.05, float("nan"), float("inf")])
def test_a_map_without_a_scale_is_refused(resolution: float) -> None:
    data = png(np.full((50, 50), 255, np.uint8))
    for read in (lambda: scaled(data, resolution), lambda: floor_of(data, resolution, (0.0, 0.0))):
        with pytest.raises(ComponentFailed, match=r"the robot's map has no scale: a pixel of it is .* m"):
            read()


def test_a_map_that_lies_nowhere_is_refused() -> None:
    with pytest.raises(ComponentFailed, match="the robot's map lies nowhere: its corner is at nan,0"):
        floor_of(png(np.full((50, 50), 255, np.uint8)), 0.05, (float("nan"), 0.0))


def test_a_floor_has_the_room_and_what_stands_in_it() -> None:
    floor = floor_of(png(HOUSE.grid()), HOUSE.resolution, (HOUSE.origin.x, HOUSE.origin.y))
    assert floor is not None
    xs, ys = zip(*floor.outline, strict=True)
    assert (min(xs), max(xs)) == (pytest.approx(-0.5, abs=0.2), pytest.approx(6.5, abs=0.2))
    assert (min(ys), max(ys)) == (pytest.approx(-2.5, abs=0.2), pytest.approx(2.5, abs=0.2))
    (table,) = floor.obstacles
    assert (min(x for x, _ in table), max(x for x, _ in table)) == (
        pytest.approx(3.2, abs=0.15),
        pytest.approx(4.0, abs=0.15),
    )


@pytest.mark.parametrize("grid", [np.zeros((50, 50), np.uint8), np.pad([[255]], 10).astype(np.uint8)])
def test_a_map_without_a_floor_has_none(grid: NDArray[np.uint8]) -> None:
    assert floor_of(png(grid), 0.05, (0.0, 0.0)) is None


def test_a_map_full_of_specks_has_no_more_corners_than_a_message_takes() -> None:
    specks = np.full((1500, 1500), 255, np.uint8)
    for row in range(50, 1450, 40):
        for column in range(50, 1450, 40):
            cv2.circle(specks, (column, row), 15, 0, -1)
    floor = floor_of(png(specks), 0.02, (0.0, 0.0))
    assert floor is not None
    assert len(floor.obstacles) <= 100
    assert len(floor.outline) + sum(map(len, floor.obstacles)) <= 1000
