"""The controls of the figure in the connected game engine."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from openrois_body.body import Body
from openrois_body.messages import Command, Input, LinkError
from openrois_body.motion.legs import Legs
from openrois_body.teleoperation.steering import Velocity

__all__ = ["FigureControls"]


class FigureControls:
    """Drives legs and eyes, and passes input on to a game engine that wants it.

    Args:
        legs: drive.
        body: looks.
        send: sends a command to the game engine.
        wants_input: returns whether the game engine said that it takes input.
    """

    def __init__(
        self, legs: Legs, body: Body, send: Callable[[Command], None], wants_input: Callable[[], bool]
    ) -> None:
        self._legs = legs
        self._body = body
        self._send = send
        self._wants_input = wants_input

    def drive(self, velocity: Velocity) -> None:
        """Go with this velocity for half a second at most; an engine without legs that takes input does it by itself.

        Raises:
            ComponentFailed: the game engine is disconnected, or its figure does not walk.
        """
        if self._legs.can_walk or not self._wants_input():
            self._legs.drive(velocity.ahead, velocity.left, velocity.turn)

    def halt(self, reason: str) -> None:
        """Stand still now."""
        self._legs.halt(reason)

    def turn_eyes(self, x: float, y: float) -> None:
        """Turn the eyes.

        Raises:
            ComponentFailed: the game engine is disconnected.
        """
        self._body.turn_eyes(x, y)

    def pass_on(self, message: Mapping[str, Any]) -> None:
        """Send the message to the game engine if it takes input; never raises."""
        if self._wants_input():
            with suppress(LinkError):
                self._send(Input(message))
