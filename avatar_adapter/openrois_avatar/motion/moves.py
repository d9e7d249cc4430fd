"""Lines and curves from where the figure stands: what `Move` means by its parameters."""

from dataclasses import replace
from math import ceil, cos, pi, radians, remainder, sin, tau
from typing import Final

from openrois.errors import BadParameter
from openrois_avatar.link.messages import Place, Waypoint
from openrois_avatar.link.messages.motion import FAR, MAX_PATH
from openrois_avatar.motion.planning import SPEED

__all__ = ["TOP_SPEED", "curve", "curve_length", "line", "speed_for"]

TOP_SPEED: Final = 2.0
"""Metres a second: the fastest that the figure walks."""
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
    """Go the millimetres straight ahead (negative: backwards), then turn by the degrees (positive: to the left).

    Raises:
        BadParameter: these are not two numbers, or they are too large: the way leads too far, or has too many steps.
    """
    millimetres, turn = _pair("line", values)
    metres = _metres("line", millimetres)
    x, y = start.x + metres * cos(start.th), start.y + metres * sin(start.th)
    path = [Waypoint(x, y)] if metres > 0 else _backwards(start, -metres)
    return _checked("line", [*path, *_turned(Place(x, y, start.th), turn)] or [Waypoint(x, y, start.th)])


def curve(start: Place, values: tuple[int, ...]) -> list[Waypoint]:
    """Go ahead on a circle of this radius until the direction has changed by the degrees (positive: to the left).

    Raises:
        BadParameter: these are not two numbers, they are too large (as in `line`), or the radius is negative.
    """
    millimetres, turn = _pair("curve", values)
    radius = _metres("curve", millimetres)
    if radius < 0:
        raise BadParameter(f"curve: the radius cannot be negative: {millimetres} mm")
    if not radius or not turn:
        return _turned(start, turn) or [Waypoint(start.x, start.y, start.th)]
    # The centre is to the left of who turns left.
    side = 1.0 if turn > 0 else -1.0
    x, y = start.x - side * radius * sin(start.th), start.y + side * radius * cos(start.th)
    parts = ceil(abs(turn) / _STEP)
    headings = [start.th + turn * part / parts for part in range(1, parts + 1)]
    path = [Waypoint(x + side * radius * sin(at), y - side * radius * cos(at)) for at in headings]
    # The last step leads along a chord: at its end the figure turns along the circle.
    return _checked("curve", [*path, replace(path[-1], th=remainder(headings[-1], tau))])


def curve_length(values: tuple[int, ...]) -> float:
    """Return the metres of a curve; raises as `curve`."""
    millimetres, turn = _pair("curve", values)
    return abs(_metres("curve", millimetres) * turn)


def speed_for(metres: float, milliseconds: int | None) -> float:
    """Return the speed (m/s) at which so many metres take so long; without a time, or a way, `SPEED`.

    Raises:
        BadParameter: the figure cannot be so fast, or so slow.
    """
    if not milliseconds or not metres:
        return SPEED
    speed = abs(metres) / milliseconds * _MILLIMETRES
    if not _SLOWEST <= speed <= TOP_SPEED:
        asked = f"{abs(metres):.2f} m in {milliseconds} ms are {speed:.2g} m/s"
        raise BadParameter(f"time: {asked}; the figure walks with {_SLOWEST:g} to {TOP_SPEED:g} m/s")
    return speed


def _pair(name: str, values: tuple[int, ...]) -> tuple[int, float]:
    """The millimetres, and the degrees in radians."""
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
    """Return a path that a game engine can be told; one that it cannot raises BadParameter."""
    if len(path) > MAX_PATH:
        raise BadParameter(f"{name}: the way has {len(path)} steps, and there can be {MAX_PATH}")
    if any(abs(at.x) > FAR or abs(at.y) > FAR for at in path):
        raise BadParameter(f"{name}: the way leads beyond {FAR:g} m")
    return path


def _backwards(start: Place, metres: float) -> list[Waypoint]:
    """Steps that are too short for turning round, each with the face ahead."""
    parts = ceil(metres / _SMALL_STEP)
    steps = [metres * part / parts for part in range(1, parts + 1)]
    return [Waypoint(start.x - step * cos(start.th), start.y - step * sin(start.th), start.th) for step in steps]


def _turned(at: Place, turn: float) -> list[Waypoint]:
    parts = ceil(abs(turn) / _TURN)
    return [Waypoint(at.x, at.y, remainder(at.th + turn * part / parts, tau)) for part in range(1, parts + 1)]
