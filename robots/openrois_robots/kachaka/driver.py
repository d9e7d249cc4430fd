"""Driving by hand: velocities to the robot while an operator drives, and none after half a second without one."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.teleoperation.steering import STANDING, Velocity
from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed, RoISError
from openrois_robots.adapter.link import RobotLink
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.error_texts import ErrorTexts
from openrois_robots.kachaka.limits import DrivingLimits, normalised

__all__ = ["HOLD", "DriveFigures", "Driver"]

_log = logging.getLogger(__name__)

HOLD: Final = 0.5
"""Seconds for which a velocity holds without the next one."""
_PERIOD: Final = 0.1
"""Seconds between two velocities that are sent while the robot is driven."""
_DEADLINE: Final = 0.3
"""Seconds that the robot has to take a velocity: the next one must not wait for long."""
_STOPS: Final = 3
"""Times that the velocity of standing is tried; then the robot's own time limit is left."""


@dataclass(slots=True)
class DriveFigures:
    """Counts of velocities since the adapter began.

    Attributes:
        sent: that the robot has taken.
        failed: that it has not.
    """

    sent: int = 0
    failed: int = 0


class Driver:
    """Drives one robot; `Controls` of its operator. `run` has to run.

    It goes ahead, back, and turns; steps to the side, a gaze and other input have no effect on it. A motion of another
    component ends when it begins: driving comes first. Manual control is switched on for it, and off when a command
    needs the robot.

    Args:
        api: of the robot.
        link: to it.
        texts: of its errors.
        limits: highest speeds.
        clock: the media clock.
    """

    def __init__(
        self, api: KachakaApi, link: RobotLink, texts: ErrorTexts, limits: DrivingLimits, clock: MediaClock
    ) -> None:
        self.figures = DriveFigures()
        self.end_motion: Callable[[str], Awaitable[None]] = _end_nothing
        """Ends the motion of another component, with a reason."""
        self._api = api
        self._link = link
        self._texts = texts
        self._limits = limits
        self._clock = clock
        self._velocity = STANDING
        self._until = 0.0
        self._woken = asyncio.Event()
        self._refusal = ""
        self._is_manual = False
        self._busy = asyncio.Lock()

    def drive(self, velocity: Velocity) -> None:
        """Go with this velocity for half a second at most; one to the side has no effect.

        Raises:
            ComponentFailed: the robot is lost, or has refused the velocity before.
        """
        if not self._link.is_up:
            raise ComponentFailed(self._link.problem)
        if refusal := self._refusal:
            self._refusal = ""
            raise ComponentFailed(refusal)
        self._velocity, self._until = velocity, self._clock.now() + HOLD
        self._woken.set()

    def halt(self, reason: str) -> None:
        """Stand still now."""
        _log.debug("the robot stands: %s", reason)
        self._velocity = STANDING
        self._woken.set()

    def turn_eyes(self, x: float, y: float) -> None:
        """Do nothing: the robot has no eyes to turn."""

    def pass_on(self, message: Mapping[str, Any]) -> None:
        """Do nothing: the robot takes no input."""

    @property
    def is_driving(self) -> bool:
        """Whether an operator drives now."""
        return self._velocity != STANDING and self._clock.now() < self._until

    async def run(self) -> None:
        """Drive until cancelled; then the robot stands, and manual control ends."""
        try:
            while True:
                await self._woken.wait()
                self._woken.clear()
                async with self._busy:
                    await self._drive()
        finally:
            if self._is_manual and self._link.is_up:
                with suppress(RoISError):
                    await self._switch(False)

    async def release(self) -> None:
        """End manual control, which the robot does not have beside commands.

        Raises:
            ComponentFailed: an operator drives, or the robot refuses.
        """
        if self.is_driving:
            raise ComponentFailed("an operator drives the robot by hand: it takes no command meanwhile")
        async with self._busy:
            if self._is_manual:
                await self._switch(False)

    async def _drive(self) -> None:
        """Send velocities until the robot stands."""
        try:
            if self.is_driving:
                await self.end_motion("an operator drives the robot by hand")
                # Each time: the robot ends manual control by itself after a while.
                await self._switch(True)
            while self.is_driving:
                await self._send(self._velocity)
                await self._next()
        except RoISError as error:
            self.figures.failed += 1
            # The next velocity raises it: the operator is told then.
            self._refusal = str(error)
            self._is_manual = False
            _log.warning("the robot is not driven: %s", error)
        finally:
            if self._is_manual:
                await self._stand()

    async def _next(self) -> None:
        """Wait until the next velocity is due, or one is wanted at once."""
        waking = asyncio.ensure_future(self._woken.wait())
        passing = asyncio.ensure_future(self._clock.sleep_until(self._clock.now() + _PERIOD))
        try:
            await asyncio.wait((waking, passing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            waking.cancel()
            passing.cancel()
        self._woken.clear()

    async def _stand(self) -> None:
        for _ in range(_STOPS):
            try:
                await self._send(STANDING)
            except RoISError as error:
                self.figures.failed += 1
                _log.warning("the robot was not told to stand: %s", error)
            else:
                return
        self._is_manual = False

    async def _send(self, velocity: Velocity) -> None:
        linear, angular = normalised(velocity.ahead, velocity.turn, self._limits)
        request = pb2.SetRobotVelocityRequest(linear=linear, angular=angular)
        response: pb2.SetRobotVelocityResponse = await self._api.call("SetRobotVelocity", request, deadline=_DEADLINE)
        self._texts.require_success(response.result, "take a velocity")
        self.figures.sent += 1

    async def _switch(self, enable: bool) -> None:
        request = pb2.SetManualControlEnabledRequest(enable=enable)
        response: pb2.SetManualControlEnabledResponse = await self._api.call("SetManualControlEnabled", request)
        self._texts.require_success(response.result, "begin manual control" if enable else "end manual control")
        self._is_manual = enable


async def _end_nothing(_reason: str) -> None:
    """Stand in until commands are there."""
