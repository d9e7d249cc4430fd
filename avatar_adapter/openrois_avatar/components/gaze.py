"""Gaze: where the avatar looks. A component of our own; the standard has none."""

from collections.abc import Callable

from openrois.component import Component, command, parameter_profile
from openrois.errors import BadParameter
from openrois.types.codes import ComponentFunction, ComponentStatus
from openrois.types.messages import Result
from openrois.types.profiles import CommandMessageProfile
from openrois_avatar.body import Body
from openrois_avatar.components.profiles import component_profile

__all__ = ["Gaze"]


class Gaze(Component):
    """Turns the eyes, and the head a little after them. Of class function: a glance is nobody's to reserve.

    Args:
        body: whose eyes.
        engine_status: tells whether the game engine works now.
    """

    def __init__(self, body: Body, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__(
            component_profile(
                "Gaze",
                ComponentFunction.FUNCTION,
                authority="OpenRoIS",
                commands=(
                    CommandMessageProfile(
                        name="look",
                        arguments=(
                            parameter_profile("x", "double", description="-1 (the viewer's left) to 1"),
                            parameter_profile("y", "double", description="-1 (down) to 1"),
                        ),
                    ),
                ),
            )
        )
        self._body = body
        self._engine_status = engine_status

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    @command("look")
    async def look(self, arguments: dict[str, str]) -> tuple[Result, ...]:
        """Look somewhere; ends at once, the eyes take their time."""
        x, y = float(arguments.get("x", "0")), float(arguments.get("y", "0"))
        if abs(x) > 1 or abs(y) > 1:
            raise BadParameter("x and y go from -1 to 1")
        self._body.look(x, y)
        return ()
