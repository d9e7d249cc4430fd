"""Settings of the tools. Pure."""

from dataclasses import dataclass
from typing import Final

from openrois_agents.tools.abilities import ACTING

__all__ = ["ToolSettings"]

IDLE: Final = 300.0
"""Seconds without a call after which a body is given back, unless the tools are set otherwise."""

MOVEMENTS: Final = 30
"""Movements a minute that a task may begin, unless the tools are set otherwise."""


@dataclass(frozen=True, slots=True)
class ToolSettings:
    """What the command line says of the tools.

    Attributes:
        idle: seconds without a call after which a body is given back.
        allowed: the tools of `ACTING` that a task may have.
        movements: how many a task may begin in a minute.
    """

    idle: float = IDLE
    allowed: frozenset[str] = frozenset(ACTING)
    movements: int = MOVEMENTS
