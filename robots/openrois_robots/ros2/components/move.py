"""Move of a robot that steers by velocity: strokes that its odometry closes (component 15)."""

from typing import Annotated, Any, Final

from openrois_body.components.moving import Figure, Moving
from openrois_body.messages import Place
from openrois_body.motion.moves import curve, curve_length, line, speed_for
from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois_robots.adapter.battery import Battery
from openrois_robots.ros2.components.bound import Bound, Ends
from openrois_robots.ros2.robot.strokes import STUCK, Limits, Strokes, curve_strokes, line_strokes
from openrois_robots.ros2.robot.wheels import Wheels

__all__ = ["Move"]

_STEP: Final = 0.05
"""Seconds between two looks at the odometry."""
_HERE: Final = Place(0, 0, 0)


class Move(Bound, Moving, components.Move):
    """Goes the last set of `line` and `curve`, in `time`.

    Args:
        figure: whose place the odometry gives.
        wheels: drive it.
        ends: that it needs.
        battery: of the robot.
    """

    time: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, figure: Figure, wheels: Wheels, ends: Ends, battery: Battery) -> None:
        super().__init__(figure)
        self.ends = ends
        self._wheels = wheels
        self._battery = battery

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Let one of `line` and `curve` replace the other; refuse both at once, and an impossible speed."""
        straight, bent = changes.get("line"), changes.get("curve")
        if straight is not None and bent is not None:
            raise BadParameter("line and curve cannot be set together; set one of them")
        if straight is not None:
            changes = {**changes, "curve": None}
        elif bent is not None:
            changes = {**changes, "line": None}
        wanted = {"line": self.line, "curve": self.curve, "time": self.time, **changes}
        self._limits(wanted["line"], wanted["curve"], wanted["time"])
        return changes

    async def start(self) -> None:
        """Go to the end of the line or curve.

        Raises:
            BadParameter: neither is set.
            ComponentFailed: the battery is low, the robot is lost, or something is in its way.
        """
        if self.line is None and self.curve is None:
            raise BadParameter("neither line nor curve is set; set one of them before start")
        if self._battery.refusal:
            raise ComponentFailed(self._battery.refusal)
        limits = self._limits(self.line, self.curve, self.time)
        parts = line_strokes(self.line) if self.line is not None else curve_strokes(self.curve or ())
        async with self.moving():
            await self.ends.link.during(self._go(Strokes(parts, limits)))

    async def _go(self, strokes: Strokes) -> None:
        clock = self.figure.legs.clock
        try:
            while (velocity := strokes.velocity(self.figure.place(), clock.now())) is not None:
                if self.is_suspended:
                    self._wheels.halt()
                    await self.going()
                    strokes.rest(clock.now())
                    continue
                if strokes.is_stuck(clock.now()):
                    raise ComponentFailed(
                        f"the robot has not come nearer to the end for {STUCK:g} s, and {strokes.left:.2f} m or rad are"
                        " left: something is in its way, or it does not obey its velocity"
                    )
                self._wheels.drive(velocity)
                await self.figure.rest(_STEP)
        finally:
            self._wheels.halt()

    def _limits(self, straight: tuple[int, ...] | None, bent: tuple[int, ...] | None, time: int | None) -> Limits:
        """Return the largest velocities of a motion; raises BadParameter where the robot cannot go so."""
        top = self._wheels.limits
        metres = 0.0
        if straight is not None:
            line(_HERE, straight)
            metres = straight[0] / 1000
        elif bent is not None:
            curve(_HERE, bent)
            metres = curve_length(bent)
        if not time or not metres:
            return top
        return Limits(speed_for(metres, time, top.speed), top.turn)
