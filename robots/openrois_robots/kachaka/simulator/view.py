"""What the cameras of the simulated robot see: a floor, walls, persons, and a number that changes."""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, remainder, sin, tau
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from openrois_robots.kachaka.simulator.house import House, Pose

__all__ = ["FOCAL", "SIZE", "Seen", "draw", "encode", "persons_in_view"]

SIZE: Final = 1280, 720
"""Width and height of the pictures, in pixels."""
FOCAL: Final = 800.0
"""Focal length, in pixels."""
_EYE: Final = 0.35
"""Height of the cameras above the floor, in metres."""
_TALL, _WIDE = 1.6, 0.45
"""Height and width of a person, in metres."""
_FAR: Final = 6.0
"""Metres up to which persons are seen."""
_QUALITY: Final = 80
_CHECKS: Final = 0.5
"""Metres of a square of the floor."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A person in a picture: its box in pixels, and how far away."""

    left: int
    top: int
    width: int
    height: int
    distance: float


def persons_in_view(house: House, pose: Pose) -> tuple[Seen, ...]:
    """Return the persons that a camera sees that looks along its robot."""
    width, height = SIZE
    found = []
    for person in house.persons:
        away = hypot(person.x - pose.x, person.y - pose.y)
        bearing = remainder(atan2(person.y - pose.y, person.x - pose.x) - pose.th, tau)
        ahead = away * cos(bearing)
        if ahead <= 0.3 or away > _FAR:
            continue
        middle = width / 2 - FOCAL * sin(bearing) / cos(bearing)
        top = height / 2 - FOCAL * (_TALL - _EYE) / ahead
        bottom = height / 2 + FOCAL * _EYE / ahead
        half = FOCAL * _WIDE / 2 / ahead
        left, right = max(0, round(middle - half)), min(width, round(middle + half))
        upper, lower = max(0, round(top)), min(height, round(bottom))
        if right - left > 10:
            found.append(Seen(left, upper, right - left, lower - upper, away))
    return tuple(found)


def draw(house: House, pose: Pose, number: int, name: str) -> NDArray[np.uint8]:
    """Return a picture (BGR, height x width x 3) of what is ahead of a pose."""
    width, height = SIZE
    picture = np.full((height, width, 3), (225, 215, 200), np.uint8)
    picture[height // 2 :] = _floor(pose)
    for box in house.furniture:
        _draw_box(picture, pose, (box.left + box.right) / 2, (box.bottom + box.top) / 2)
    for seen in persons_in_view(house, pose):
        corner = seen.left + seen.width, seen.top + seen.height
        cv2.rectangle(picture, (seen.left, seen.top), corner, (120, 90, 60), -1)
        head = max(4, seen.width // 4)
        cv2.circle(picture, (seen.left + seen.width // 2, seen.top + head), head, (150, 180, 220), -1)
    # A bar that goes round, and the number, change from picture to picture.
    at = number * 16 % width
    cv2.rectangle(picture, (at, height - 40), (min(width, at + 60), height - 10), (40, 60, 220), -1)
    cv2.putText(picture, f"{name} {number}", (20, 50), cv2.FONT_HERSHEY_SIMPLEX, 1.5, (30, 30, 30), 3)
    return picture


def encode(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture as JPEG."""
    _, data = cv2.imencode(".jpg", picture, (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))
    return data.tobytes()


def _floor(pose: Pose) -> NDArray[np.uint8]:
    """Return the lower half of a picture: squares, by where a pixel's ray meets the floor."""
    width, height = SIZE
    rows, columns = np.indices((height // 2, width // 4), dtype=np.float32)
    ahead = _EYE * FOCAL / (rows + 4)
    aside = ahead * (width / 2 - 4 * columns) / FOCAL
    x = pose.x + ahead * cos(pose.th) - aside * sin(pose.th)
    y = pose.y + ahead * sin(pose.th) + aside * cos(pose.th)
    odd = (np.floor(x / _CHECKS) + np.floor(y / _CHECKS)).astype(np.int32) & 1
    colours = np.array([(150, 160, 170), (185, 195, 205)], np.uint8)[odd]
    return np.repeat(colours, 4, axis=1)


def _draw_box(picture: NDArray[np.uint8], pose: Pose, x: float, y: float) -> None:
    width, height = SIZE
    bearing = remainder(atan2(y - pose.y, x - pose.x) - pose.th, tau)
    ahead = hypot(x - pose.x, y - pose.y) * cos(bearing)
    if ahead < 0.5 or abs(bearing) > pi / 3:
        return
    middle = width / 2 - FOCAL * sin(bearing) / cos(bearing)
    half, top = FOCAL * 0.5 / ahead, height / 2 - FOCAL * 0.4 / ahead
    corners = (round(middle - half), round(top)), (round(middle + half), round(height / 2 + FOCAL * _EYE / ahead))
    cv2.rectangle(picture, *corners, (60, 90, 130), -1)
