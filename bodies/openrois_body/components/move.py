"""Move: the body goes along a line or a curve (component 15)."""

from math import hypot
from typing import Annotated, Any

from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois.errors import Aborted
from openrois_body.components.moving import Moving
from openrois_body.messages import Floor, Place, Waypoint
from openrois_body.motion.legs import Motion
from openrois_body.motion.moves import curve, curve_length, line, speed_for

__all__ = ["Move"]

_HERE = Place(0, 0, 0)


class Move(Moving, components.Move):
    """Walks the last set of `line` and `curve`, in `time`.

    Args:
        figure: what walks.
    """

    time: Annotated[int, Field(ge=0)] | None = parameter(None)

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
        self._speed(wanted["line"], wanted["curve"], wanted["time"])
        return changes

    async def start(self) -> None:
        """Walk the line or curve to its end."""
        if self.line is None and self.curve is None:
            raise BadParameter("neither line nor curve is set; set one of them before start")
        speed = self._speed(self.line, self.curve, self.time)
        place = self.figure.place()
        path = line(place, self.line) if self.line is not None else curve(place, self.curve or ())
        async with self.moving() as motion:
            leave = self.figure.world.changed.add(
                lambda change: self.replan(motion) if isinstance(change, Floor) else None
            )
            try:
                await self._walk(motion, path, speed)
            finally:
                leave()

    async def _walk(self, motion: Motion, path: list[Waypoint], speed: float) -> None:
        """Walk a path to its end, in several walks where the component is suspended or the floor changes."""
        while path:
            await self.going()
            await self._check(path)
            if self.is_suspended:
                continue
            gone = 0

            def reached(index: int) -> None:
                nonlocal gone
                gone = index + 1

            ended = await motion.walk(path, speed, reached)
            if ended == "OK":
                return
            if ended == "ABORT":
                raise Aborted("the body broke the motion off")
            path = path[gone:]

    async def _check(self, path: list[Waypoint]) -> None:
        place = self.figure.place()
        if any(hypot(at.x - place.x, at.y - place.y) > 0 for at in path):
            try:
                await self.figure.ways.check(place, path)
            except ComponentFailed as error:
                raise ComponentFailed(f"{self.name}: {error}") from error

    def _speed(self, straight: tuple[int, ...] | None, bent: tuple[int, ...] | None, time: int | None) -> float:
        """Return the speed in m/s; raises BadParameter where the body cannot go so."""
        metres = 0.0
        if straight is not None:
            line(_HERE, straight)
            metres = straight[0] / 1000
        elif bent is not None:
            curve(_HERE, bent)
            metres = curve_length(bent)
        return speed_for(metres, time, self.figure.legs.top_speed)
