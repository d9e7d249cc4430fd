"""Targets as applications write them: a position `x,y` or `x,y,th`, or the ref, id or name of a thing. Pure."""

from dataclasses import dataclass
from math import inf, isfinite, remainder, tau
from typing import Final

from openrois.errors import BadParameter
from openrois_body.messages import FAR, Thing
from openrois_body.motion.world import World

__all__ = ["MAX_TARGETS", "Position", "read_target", "read_targets"]

MAX_TARGETS: Final = 100
"""Most targets of one route."""


@dataclass(frozen=True, slots=True)
class Position:
    """A place in metres, and the direction there in radians; None for the direction of the way."""

    x: float
    y: float
    th: float | None = None


def read_targets(texts: tuple[str, ...], world: World) -> tuple[Position | Thing, ...]:
    """Read the targets of a route; raises as `read_target`, and for none or too many."""
    if not 1 <= len(texts) <= MAX_TARGETS:
        raise BadParameter(f"target_positions: expected 1 to {MAX_TARGETS} positions")
    return tuple(read_target(text, world) for text in texts)


def read_target(text: str, world: World) -> Position | Thing:
    """Read one target.

    Raises:
        BadParameter: it is neither a position nor a thing of the scene; the text names it.
    """
    parts = text.split(",")
    numbers = [_number(part) for part in parts]
    if None in numbers or len(numbers) not in (2, 3):
        return world.find(text)
    x, y, th = (*(inf if number is None else number for number in numbers), 0.0)[:3]
    if not (abs(x) <= FAR and abs(y) <= FAR and isfinite(th)):
        raise BadParameter(f"{text!r}: expected metres from -{FAR:g} to {FAR:g}, and radians")
    return Position(x, y, remainder(th, tau) if len(numbers) == 3 else None)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
