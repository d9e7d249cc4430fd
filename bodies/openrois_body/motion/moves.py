"""The paths of `Move`: lines and curves from where the figure stands. Pure."""

from dataclasses import replace
from math import ceil, cos, pi, radians, remainder, sin, tau
from typing import Final

from openrois.errors import BadParameter
from openrois_body.messages import FAR, MAX_PATH, Place, Waypoint
from openrois_body.motion.planning import SPEED

__all__ = ["curve", "curve_length", "line", "speed_for"]

_SLOWEST: Final = 0.01
_MOST_DEGREES: Final = 3600
_TURN: Final = pi / 2
"""The most that the figure turns from one point to the next: beyond half a turn it would choose the other way round."""
_STEP: Final = pi / 18
"""The most that a curve turns from one point to the next: a circle of one metre is 4 mm away from its chords."""
_SMALL_STEP: Final = 0.4
"""Metres: a figure may turn along the way to a point that is further away."""
_MILLIMETRES: Final = 1000.0


def line(start: Place, values: tuple[int, ...]) -> list[Waypoint]:
    """Return the path of a line: millimetres straight ahead (negative: backwards), then degrees of turn to the left.

    Raises:
        BadParameter: not two numbers, or too large ones: the way leads too far, or has too many steps.
    """
    millimetres, turn = _pair("line", values)
    metres = _metres("line", millimetres)
    x, y = start.x + metres * cos(start.th), start.y + metres * sin(start.th)
    path = [Waypoint(x, y)] if metres > 0 else _backwards(start, -metres)
    return _checked("line", [*path, *_turned(Place(x, y, start.th), turn)] or [Waypoint(x, y, start.th)])


def curve(start: Place, values: tuple[int, ...]) -> list[Waypoint]:
    """Return the path of a curve: on a circle of this radius until the direction has changed (positive: left).

    Raises:
        BadParameter: not two numbers, too large ones (as in `line`), or a negative radius.
    """
    millimetres, turn = _pair("curve", values)
    radius = _metres("curve", millimetres)
    if radius < 0:
        raise BadParameter(f"curve: the radius must be 0 mm or more, not {millimetres}")
    if not radius or not turn:
        return _turned(start, turn) or [Waypoint(start.x, start.y, start.th)]
    # A figure that turns left has the centre on its left.
    side = 1.0 if turn > 0 else -1.0
    x, y = start.x - side * radius * sin(start.th), start.y + side * radius * cos(start.th)
    parts = ceil(abs(turn) / _STEP)
    headings = [start.th + turn * part / parts for part in range(1, parts + 1)]
    path = [Waypoint(x + side * radius * sin(at), y - side * radius * cos(at)) for at in headings]
    # The last step leads along a chord: at its end the figure turns along the circle.
    return _checked("curve", [*path, replace(path[-1], th=remainder(headings[-1], tau))])


def curve_length(values: tuple[int, ...]) -> float:
    """Return the length of a curve in metres; raises as `curve`."""
    millimetres, turn = _pair("curve", values)
    return abs(_metres("curve", millimetres) * turn)


def speed_for(metres: float, milliseconds: int | None, top_speed: float) -> float:
    """Return the speed (m/s) for so many metres in this time; `SPEED` without a time or a way.

    Raises:
        BadParameter: the body cannot be so fast, which reaches `top_speed`, or so slow.
    """
    if not milliseconds or not metres:
        return SPEED
    speed = abs(metres) / milliseconds * _MILLIMETRES
    if not _SLOWEST <= speed <= top_speed:
        asked = f"{abs(metres):.2f} m in {milliseconds} ms are {speed:.2g} m/s"
        raise BadParameter(f"time: {asked}; the speed must be between {_SLOWEST:g} and {top_speed:g} m/s")
    return speed


def _pair(name: str, values: tuple[int, ...]) -> tuple[int, float]:
    """Return the millimetres, and the degrees in radians."""
    if len(values) != 2:
        raise BadParameter(f"{name}: expected two numbers, millimetres and degrees")
    if abs(values[1]) > _MOST_DEGREES:
        raise BadParameter(f"{name}: expected at most {_MOST_DEGREES} degrees, not {values[1]}")
    return values[0], radians(values[1])


def _metres(name: str, millimetres: int) -> float:
    if abs(millimetres) > FAR * _MILLIMETRES:
        raise BadParameter(f"{name}: expected at most {FAR * _MILLIMETRES:.0f} mm, not {millimetres}")
    return millimetres / _MILLIMETRES


def _checked(name: str, path: list[Waypoint]) -> list[Waypoint]:
    """Return the path if a game engine can be sent it; else raise BadParameter."""
    if len(path) > MAX_PATH:
        raise BadParameter(
            f"{name}: the way has {len(path)} steps, and at most {MAX_PATH} are possible; choose a shorter one"
        )
    if any(abs(at.x) > FAR or abs(at.y) > FAR for at in path):
        raise BadParameter(f"{name}: the way leads beyond {FAR:g} m; choose a shorter one")
    return path


def _backwards(start: Place, metres: float) -> list[Waypoint]:
    """Return backward steps, each too short for turning round, with the face ahead."""
    parts = ceil(metres / _SMALL_STEP)
    steps = [metres * part / parts for part in range(1, parts + 1)]
    return [Waypoint(start.x - step * cos(start.th), start.y - step * sin(start.th), start.th) for step in steps]


def _turned(at: Place, turn: float) -> list[Waypoint]:
    parts = ceil(abs(turn) / _TURN)
    return [Waypoint(at.x, at.y, remainder(at.th + turn * part / parts, tau)) for part in range(1, parts + 1)]
