"""Settings of the tools. Pure."""

from dataclasses import dataclass
from typing import Final

__all__ = ["ACTING", "CALL", "ToolSettings"]

CALL: Final = "call"
"""The tool for what has no tool of its own. As it may move anything, a task has to name it."""

ACTING: Final = ("say", "gesture", "look_at", "go_to", CALL)
"""Every tool that acts on a body: what a task may name, and what the command line may withhold from all tasks."""

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
        pictures: whether `look` takes any.
    """

    idle: float = IDLE
    allowed: frozenset[str] = frozenset(ACTING)
    movements: int = MOVEMENTS
    pictures: bool = True
