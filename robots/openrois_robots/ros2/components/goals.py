"""Goals of the robot's NavigateToPose, one at a time; Navigation and Follow share them."""

import asyncio
import logging
from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from typing import Any, Final

from openrois_streaming.clock import MediaClock

from openrois.errors import ComponentFailed
from openrois_robots.ros2.graph.backend import ActionClient, Goal, GoalResult, Publisher
from openrois_robots.ros2.mapping.reading import read_place
from openrois_robots.ros2.mapping.settings import Navigation, Place
from openrois_robots.ros2.robot.poses import Heard, pose_message

__all__ = ["CANCEL_TIMEOUT", "Goals"]

CANCEL_TIMEOUT: Final = 0.4
"""Seconds within which the robot has to confirm that it cancels a goal: a stop takes no longer than half a second."""

_ORPHANS: Final = 10
"""Goals that wait for being cancelled."""
_RETRY: Final = 0.2
"""Seconds between two tries."""

_log = logging.getLogger(__name__)


class Goals:
    """Sends goals to the robot.

    Args:
        action: of the robot.
        settings: of the navigation.
        places: by their names.
        max_speed: m/s, which is published as the limit of Nav2 where the settings name its topic.
        speed_limit: publishes it; None: the settings name no topic.
        pose: returns the robot's last pose in its map.
        stand: lets the robot stand by its velocity, where a goal cannot be cancelled; must not raise.
        clock: the media clock.
    """

    def __init__(
        self,
        action: ActionClient,
        settings: Navigation,
        places: Mapping[str, Place],
        max_speed: float,
        speed_limit: Publisher | None,
        pose: Callable[[], Heard | None],
        stand: Callable[[], None],
        clock: MediaClock,
    ) -> None:
        self.settings = settings
        self.places = places
        self.pose = pose
        self._action = action
        self._max_speed = max_speed
        self._speed_limit = speed_limit
        self._stand = stand
        self._clock = clock
        self._running: Goal | None = None
        self._orphans: deque[Goal] = deque(maxlen=_ORPHANS)
        self._orphaned = asyncio.Event()

    def place(self, text: str) -> Place | None:
        """Return the place of a name, or of `x,y` or `x,y,th`; None: it is none."""
        return self.places.get(text) or read_place(text)

    async def send_goal(self, x: float, y: float, th: float) -> Goal:
        """Send a goal, in place of one that runs; return when it is accepted.

        Raises:
            GoalRejected: the robot does not accept it.
            NoAnswer: it has not answered.
        """
        if self._speed_limit is not None:
            self._speed_limit.publish({"percentage": False, "speed_limit": self._max_speed})
        pose = pose_message(x, y, th, self.settings.frame, self._clock.wall())
        goal = await self._action.send_goal({"pose": pose, "behavior_tree": self.settings.behavior_tree})
        self._running = goal
        return goal

    async def cancel(self) -> None:
        """Cancel the goal that runs.

        Raises:
            NoAnswer: the robot has not confirmed it.
        """
        if self._running is not None:
            await self._running.cancel(CANCEL_TIMEOUT)
            self._running = None

    @asynccontextmanager
    async def pursued(self, x: float, y: float, th: float) -> AsyncIterator["asyncio.Future[GoalResult]"]:
        """Pursue a goal while the block runs; yields a future with its end, and cancels the goal that has none.

        Raises:
            GoalRejected: the robot does not accept it.
            NoAnswer: it has not answered.
        """
        goal = await self.send_goal(x, y, th)
        ending = asyncio.ensure_future(goal.result())
        try:
            yield ending
        finally:
            await self.give_up(ending)

    async def give_up(self, ending: "asyncio.Future[GoalResult]") -> None:
        """Cancel the goal that runs, unless it has ended; where the robot does not confirm it, later again."""
        if ending.done():
            self._running = None
            # A goal whose server is gone has an error, which whoever awaits it is told.
            ending.cancelled() or ending.exception()
            return
        ending.cancel()
        try:
            await self.cancel()
        except ComponentFailed as error:
            _log.warning("a goal is not cancelled yet: %s", error)
            if self._running is not None:
                self._orphans.append(self._running)
                self._orphaned.set()
            self._running = None
            self._stand()
        await asyncio.wait({ending})

    async def run(self) -> None:
        """Cancel the goals that could not be cancelled as soon as they can, until cancelled.

        A robot that hung, or was out of reach, would go on with a goal that no application wants any more.
        """
        while True:
            await self._orphaned.wait()
            while self._orphans:
                try:
                    await self._orphans[0].cancel(CANCEL_TIMEOUT)
                    self._orphans.popleft()
                except ComponentFailed:
                    await self._clock.sleep_until(self._clock.now() + _RETRY)
            self._orphaned.clear()

    def reason(self, end: GoalResult) -> str:
        """Return what the robot says of a goal that has not succeeded."""
        text: Any = getattr(end.result, "error_msg", "")
        code: Any = getattr(end.result, "error_code", 0)
        return str(text) or (f"error code {code}" if code else f"the goal was {end.outcome}")
