"""Gaze: where the avatar looks. A component of our own; the standard has none."""

from collections.abc import Callable
from typing import Annotated

from pydantic import Field

from openrois.adapter import Component, ComponentStatus, command
from openrois_avatar.body import Body

__all__ = ["Gaze"]

Coordinate = Annotated[float, Field(ge=-1, le=1)]


class Gaze(Component, authority="OpenRoIS", function="function"):
    """Turns the eyes, and the head a little after them. Of class function: a glance is nobody's to reserve.

    Args:
        body: whose eyes.
        engine_status: tells whether the game engine works now.
    """

    def __init__(self, body: Body, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__()
        self._body = body
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    @command
    async def look(self, x: Coordinate = 0, y: Coordinate = 0) -> None:
        """Look somewhere; ends at once, the eyes take their time.

        Args:
            x: -1 (the viewer's left) to 1
            y: -1 (down) to 1
        """
        self._body.look(x, y)
