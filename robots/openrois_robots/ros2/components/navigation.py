"""Navigation by the robot's own NavigateToPose, which finds the ways (component 13)."""

import asyncio
from math import atan2
from typing import Annotated, Any, Final

from openrois_body.components.moving import Figure, Moving
from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois.errors import Aborted
from openrois_robots.adapter.battery import Battery
from openrois_robots.ros2.components.bound import Bound, Ends
from openrois_robots.ros2.components.goals import Goals
from openrois_robots.ros2.mapping.settings import Place

__all__ = ["Navigation"]

MOST: Final = 100
"""Targets of one route."""


class Navigation(Bound, Moving, components.Navigation, omit=("routing_policy",)):
    """Takes the robot to `target_positions` in turn: `x,y` or `x,y,th` in the frame of its map, or names of places.

    Args:
        figure: the robot.
        goals: takes it there.
        ends: that it needs.
        battery: of the robot.
    """

    time_limit: Annotated[int, Field(ge=0)] = parameter(0)

    def __init__(self, figure: Figure, goals: Goals, ends: Ends, battery: Battery) -> None:
        super().__init__(figure)
        self.ends = ends
        self._goals = goals
        self._battery = battery
        self._stopping = asyncio.Event()

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse targets that are neither positions nor places."""
        targets = changes.get("target_positions")
        if targets is not None:
            self._read(targets)
        return changes

    async def start(self) -> None:
        """Go to the last target.

        Raises:
            BadParameter: no target is set.
            ComponentFailed: the battery is low and the targets are not the dock alone, the robot is lost, or it cannot
                get there.
            Aborted: the goal was cancelled.
        """
        targets = self.target_positions
        if not targets:
            raise BadParameter("target_positions is not set; set it before start")
        places = self._read(targets)
        if self._battery.refusal and any(text != self._goals.settings.dock for text in targets):
            raise ComponentFailed(self._battery.refusal)
        async with self.moving(self.time_limit):
            await self.ends.link.during(self._visit(tuple(zip(targets, places, strict=True))))

    async def stop(self) -> None:
        """Cancel the goal, and let the robot stand.

        Raises:
            NoAnswer: the robot has not confirmed that it cancels the goal.
        """
        await super().stop()
        await self._goals.cancel()

    async def suspend(self) -> None:
        """Cancel the goal until `resume`, which sends it again."""
        await super().suspend()
        self._stopping.set()

    async def _visit(self, targets: tuple[tuple[str, Place], ...]) -> None:
        for index, (text, place) in enumerate(targets):
            while not await self._reach(text, place):
                await self.going()
            self.reached_target(text, index + 1 == len(targets))

    async def _reach(self, text: str, place: Place) -> bool:
        """Go to a place; return False where the component was suspended on the way."""
        await self.going()
        self._stopping.clear()
        th = place.th
        if th is None:
            at = self._goals.pose()
            th = 0.0 if at is None else atan2(place.y - at.y, place.x - at.x)
        async with self._goals.pursued(place.x, place.y, th) as ending:
            interrupted = asyncio.ensure_future(self._stopping.wait())
            try:
                either: set[asyncio.Future[Any]] = {ending, interrupted}
                await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            finally:
                interrupted.cancel()
            if not ending.done():
                return False
            end = ending.result()
        if end.outcome == "canceled":
            raise Aborted(f"{text!r}: the goal was cancelled, by a stop or by another node")
        if end.outcome != "succeeded":
            raise ComponentFailed(f"{text!r}: the robot could not get there: {self._goals.reason(end)}")
        return True

    def _read(self, texts: tuple[str, ...]) -> tuple[Place, ...]:
        if not 1 <= len(texts) <= MOST:
            raise BadParameter(f"target_positions: expected 1 to {MOST} positions")
        return tuple(self._goals.place(text) or _refuse(text, self._goals) for text in texts)


def _refuse(text: str, goals: Goals) -> Place:
    names = ", ".join(repr(each) for each in list(goals.places)[:10]) or "none"
    raise BadParameter(f"{text!r} is neither a position x,y or x,y,th nor a place; the places are {names}")
