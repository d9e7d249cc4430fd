"""Follow: goals of the robot's NavigateToPose, renewed as the pose of a target moves (component 14)."""

import asyncio
from collections.abc import Mapping
from math import atan2, cos, dist, sin
from typing import Annotated, Any, Final

from openrois_body.components.moving import Figure, Moving
from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois_robots.adapter.battery import Battery
from openrois_robots.ros2.components.bound import Bound, Ends
from openrois_robots.ros2.components.goals import Goals
from openrois_robots.ros2.graph.backend import GoalResult
from openrois_robots.ros2.robot.state import PoseState

__all__ = ["Follow"]

_LOOK: Final = 0.2
"""Seconds between two looks at the target."""
_APART: Final = 0.6
"""Metres from middle to middle that the robot keeps at least, whatever `distance` says."""
_WORTH_GOING: Final = 0.15
"""Metres beyond the distance that are worth a goal."""
_MOVED: Final = 0.25
"""Metres by which the target has to move for another goal."""
_PACE: Final = 1.0
"""Seconds between two goals: each makes the robot plan a way."""
_FRESH: Final = 2.0
"""Seconds for which the pose of a target counts."""
_GONE: Final = 5.0
"""Seconds for which there may be no pose of it."""
_TRIES: Final = 3
"""Goals in a row that the robot may give up."""


class Follow(Bound, Moving, components.Follow):
    """Keeps within `distance` of what `target_object_ref` names, until `stop`.

    Args:
        figure: the robot.
        goals: takes it after the target.
        targets: their last poses, by name.
        ends: that it needs.
        battery: of the robot.
    """

    distance: Annotated[int, Field(ge=0, le=100_000)] | None = parameter(None)
    time_limit: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(
        self, figure: Figure, goals: Goals, targets: Mapping[str, PoseState], ends: Ends, battery: Battery
    ) -> None:
        super().__init__(figure)
        self.ends = ends
        self._goals = goals
        self._targets = targets
        self._battery = battery

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a target that the mapping file does not have."""
        target = changes.get("target_object_ref")
        if target is not None:
            self._find(target)
        return changes

    async def start(self) -> None:
        """Follow until `stop`, a time limit or a failure.

        Raises:
            BadParameter: the target or the distance is not set.
            ComponentFailed: the battery is low, the robot or the target is lost, or the robot cannot get there.
        """
        if self.target_object_ref is None or self.distance is None:
            raise BadParameter("set target_object_ref and distance first")
        if self._battery.refusal:
            raise ComponentFailed(self._battery.refusal)
        target = self._find(self.target_object_ref)
        async with self.moving(self.time_limit):
            await self.ends.link.during(self._follow(target, max(_APART, self.distance / 1000)))

    async def stop(self) -> None:
        """Cancel the goal, and let the robot stand.

        Raises:
            NoAnswer: the robot has not confirmed that it cancels the goal.
        """
        await super().stop()
        await self._goals.cancel()

    async def _follow(self, target: PoseState, metres: float) -> None:
        pursuit = _Pursuit(self._goals)
        clock = self.figure.legs.clock
        seen_at = clock.now()
        try:
            while True:
                if self.is_suspended:
                    await pursuit.cancel_goal()
                    await self.going()
                    seen_at = clock.now()
                now = clock.now()
                if target.heard is not None and now - target.came_at <= _FRESH:
                    seen_at = now
                    await self._approach(pursuit, target, metres, now)
                elif now - seen_at > _GONE:
                    raise ComponentFailed(f"{self.target_object_ref!r} has not been seen for {_GONE:g} s")
                pursuit.check()
                await self.figure.rest(_LOOK)
        finally:
            await pursuit.cancel_goal()

    async def _approach(self, pursuit: "_Pursuit", target: PoseState, metres: float, now: float) -> None:
        at, robot, frame = target.heard, self._goals.pose(), self._goals.settings.frame
        assert at is not None
        if robot is None or not at.frame == robot.frame == frame:
            there = "unknown" if robot is None else f"in {robot.frame!r}"
            raise ComponentFailed(
                f"the target is in the frame {at.frame!r}, the robot {there}, and goals are in {frame!r}: all three"
                " have to be one; name the robot's pose in its map as [pose]"
            )
        away = dist((at.x, at.y), (robot.x, robot.y))
        if away <= metres + _WORTH_GOING:
            await pursuit.cancel_goal()
            return
        if pursuit.is_worth(at.x, at.y, now):
            th = atan2(at.y - robot.y, at.x - robot.x)
            await pursuit.go(at.x, at.y, (at.x - metres * cos(th), at.y - metres * sin(th), th), now)

    def _find(self, name: str) -> PoseState:
        found = self._targets.get(name)
        if found is None:
            there = ", ".join(repr(each) for each in self._targets)
            raise BadParameter(f"{name!r} cannot be followed; there is {there}")
        return found


class _Pursuit:
    """The goals of one `start`: each replaces the one before it, as the navigation of ROS does."""

    def __init__(self, goals: Goals) -> None:
        self._goals = goals
        self._ending: asyncio.Future[GoalResult] | None = None
        self._towards = 0.0, 0.0
        self._sent_at = 0.0
        self._tries = 0

    def is_worth(self, x: float, y: float, now: float) -> bool:
        """Return whether a target there is worth another goal."""
        if self._ending is None:
            return now - self._sent_at >= _PACE or not self._sent_at
        return now - self._sent_at >= _PACE and dist(self._towards, (x, y)) > _MOVED

    async def go(self, x: float, y: float, goal: tuple[float, float, float], now: float) -> None:
        """Go to a goal, for a target at `x` and `y`."""
        # The one before it runs until this one is accepted: what ends meanwhile has to cancel it.
        sent = await self._goals.send_goal(*goal)
        if self._ending is not None:
            self._ending.cancel()
        self._ending = asyncio.ensure_future(sent.result())
        self._towards, self._sent_at = (x, y), now

    def check(self) -> None:
        """Note that a goal has ended.

        Raises:
            ComponentFailed: the robot has given up too often, or its node is gone.
        """
        ending = self._ending
        if ending is None or not ending.done():
            return
        self._ending = None
        end = ending.result()
        if end.outcome == "succeeded":
            self._tries = 0
            return
        self._tries += 1
        if self._tries == _TRIES:
            raise ComponentFailed(f"the robot could not follow, {_TRIES} times: {self._goals.reason(end)}")

    async def cancel_goal(self) -> None:
        """Cancel what runs."""
        ending, self._ending = self._ending, None
        if ending is not None:
            await self._goals.give_up(ending)
