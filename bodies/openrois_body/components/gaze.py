"""Gaze: where the body looks. A component of OpenRoIS; the standard has none."""

from collections.abc import Callable
from typing import Annotated, Protocol

from pydantic import Field

from openrois.adapter import Component, ComponentStatus, command

__all__ = ["Eyes", "Gaze"]

Coordinate = Annotated[float, Field(ge=-1, le=1)]


class Eyes(Protocol):
    """What looks; `openrois_body.body.Body` implements it."""

    def turn_eyes(self, x: float, y: float) -> None:
        """Look somewhere; raises ComponentFailed."""
        ...


class Gaze(Component, authority="OpenRoIS", function="actuation", part="gaze"):
    """Turns the eyes, and the head a little after them.

    Args:
        eyes: look.
        engine_status: returns the status of the game engine.
    """

    def __init__(self, eyes: Eyes, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__()
        self._eyes = eyes
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    @command
    async def look(self, x: Coordinate = 0, y: Coordinate = 0) -> None:
        """Look somewhere; ends at once, the eyes take their time.

        Args:
            x: -1 (the viewer's left) to 1
            y: -1 (down) to 1
        """
        self._eyes.turn_eyes(x, y)
