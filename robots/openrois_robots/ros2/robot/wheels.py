"""The velocity that the robot is told: within its limits, repeated while it holds, and zero when nothing renews it."""

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from math import inf
from typing import Any, Final

from openrois_body.messages import Command, Drive, Halt
from openrois_body.teleoperation.steering import STANDING, Velocity
from openrois_streaming.clock import MediaClock

from openrois.errors import ComponentFailed
from openrois_robots.ros2.graph.backend import Publisher
from openrois_robots.ros2.robot.strokes import Limits, clamped

__all__ = ["HOLD", "PERIOD", "Wheels"]

HOLD: Final = 0.35
"""Seconds for which a velocity holds: the dead man's switch between this adapter's parts."""
PERIOD: Final = 0.1
"""Seconds between two messages while it holds: robots stop by themselves where none comes for some time."""
_FAREWELLS: Final = 3
"""Messages that say zero at the end of a motion: one may be lost where the robot hears best-effort."""


class Wheels:
    """Publishes the velocity; `run` has to run.

    Args:
        publisher: of the velocity.
        limits: that no message exceeds.
        clock: monotonic seconds, and the time of stamped messages.
        frame: of a `TwistStamped`; None: it is a `Twist`.
        sideways: whether the robot can step sideways.
    """

    def __init__(
        self,
        publisher: Publisher,
        limits: Limits,
        clock: MediaClock,
        frame: str | None = None,
        *,
        sideways: bool = False,
    ) -> None:
        self.publisher = publisher
        self.limits = limits
        self._clock = clock
        self._frame = frame
        self._sideways = sideways
        self._velocity = STANDING
        self._until = -inf
        self._farewells = 0
        self._woken = asyncio.Event()

    def send(self, command: Command) -> None:
        """Obey `Drive` and `Halt`; what else bodies are told, a robot without a figure does not do.

        Raises:
            ComponentFailed: the velocity cannot be published.
        """
        match command:
            case Drive(ahead=ahead, left=left, turn=turn):
                self.drive(Velocity(ahead, left, turn))
            case Halt():
                self.halt()

    def drive(self, velocity: Velocity) -> None:
        """Go with this velocity, or as near to it as the limits allow, for `HOLD` seconds at most.

        Raises:
            ComponentFailed: no node subscribes to the velocity, or it cannot be published.
        """
        if self.publisher.problem:
            self._until = -inf
            raise ComponentFailed(self.publisher.problem)
        asked = velocity if self._sideways else Velocity(velocity.ahead, 0.0, velocity.turn)
        self._velocity, self._until = clamped(asked, self.limits), self._clock.now() + HOLD
        self._farewells = _FAREWELLS
        self._publish(self._velocity)
        self._woken.set()

    def halt(self) -> None:
        """Stand still now.

        Raises:
            ComponentFailed: the velocity cannot be published.
        """
        self._until, self._velocity = -inf, STANDING
        self._farewells = _FAREWELLS - 1
        self._publish(STANDING)
        self._woken.set()

    async def run(self) -> None:
        """Repeat what holds, and say zero when it holds no more, until cancelled; then say zero."""
        try:
            while True:
                await self._woken.wait()
                self._woken.clear()
                while self._until != -inf or self._farewells:
                    await self._clock.sleep_until(self._clock.now() + PERIOD)
                    self._repeat()
        finally:
            with suppress(ComponentFailed):
                self._publish(STANDING)

    def _repeat(self) -> None:
        if self._clock.now() >= self._until:
            self._until, self._velocity = -inf, STANDING
            self._farewells -= 1
        with suppress(ComponentFailed):
            self._publish(self._velocity)

    def _publish(self, velocity: Velocity) -> None:
        twist: Mapping[str, Any] = {
            "linear": {"x": float(velocity.ahead), "y": float(velocity.left), "z": 0.0},
            "angular": {"x": 0.0, "y": 0.0, "z": float(velocity.turn)},
        }
        if self._frame is not None:
            wall = self._clock.wall()
            stamp = {"sec": int(wall), "nanosec": int(wall % 1 * 1e9)}
            twist = {"header": {"stamp": stamp, "frame_id": self._frame}, "twist": twist}
        self.publisher.publish(twist)
