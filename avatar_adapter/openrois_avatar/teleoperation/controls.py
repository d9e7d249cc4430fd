"""The controls of the figure in whichever game engine is connected now."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from openrois_avatar.body import Body
from openrois_avatar.legs import Legs
from openrois_avatar.link.messages import Command, Input, LinkError
from openrois_avatar.teleoperation.steering import Velocity

__all__ = ["FigureControls"]


class FigureControls:
    """Legs, eyes, and a game engine that wants to know everything.

    Args:
        legs: drive.
        body: looks.
        send: sends a command to the game engine.
        wants_input: tells whether the game engine said that it takes input.
    """

    def __init__(
        self, legs: Legs, body: Body, send: Callable[[Command], None], wants_input: Callable[[], bool]
    ) -> None:
        self._legs = legs
        self._body = body
        self._send = send
        self._wants_input = wants_input

    def drive(self, velocity: Velocity) -> None:
        """Go so for half a second at most; a game engine without legs that takes input sees to it itself.

        Raises:
            ComponentFailed: the game engine is gone, or its figure does not walk.
        """
        if self._legs.can_walk or not self._wants_input():
            self._legs.drive(velocity.ahead, velocity.left, velocity.turn)

    def halt(self, reason: str) -> None:
        """Stand still now."""
        self._legs.halt(reason)

    def look(self, x: float, y: float) -> None:
        """Look somewhere.

        Raises:
            ComponentFailed: the game engine is gone.
        """
        self._body.look(x, y)

    def pass_on(self, message: Mapping[str, Any]) -> None:
        """Give the message to the game engine if it wants to know; never raises."""
        if self._wants_input():
            with suppress(LinkError):
                self._send(Input(message))
