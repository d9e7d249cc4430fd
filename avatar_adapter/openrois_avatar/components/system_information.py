"""SystemInformation: where the avatar stands, and whether its engine works (component 1 of the standard)."""

import time
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Final

from openrois.adapter import ComponentStatus, components
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult

__all__ = ["SystemInformation"]

_ORIGIN: Final = "0.0,0.0,0.0"


class SystemInformation(components.SystemInformation, function="sensing"):
    """Answers from the game engine's connection; has no RoIS_Common, like the standard's profile.

    Args:
        avatar_ref: the id by which the avatar is known, the only entry of `robot_ref`.
        engine_status: tells whether the game engine works now.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        avatar_ref: str,
        engine_status: Callable[[], ComponentStatus],
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__("SystemInformation")
        self._avatar_ref = avatar_ref
        self._engine_status = engine_status
        self._wall_clock = wall_clock
        self._operable_since = self._now()

    def _now(self) -> datetime:
        return datetime.fromtimestamp(self._wall_clock(), UTC)

    async def robot_position(self) -> RobotPositionResult:
        """Return the moment, the avatar and its place `x,y,th`: it stands at the origin of its scene."""
        return RobotPositionResult(position_data=(_ORIGIN,), robot_ref=(self._avatar_ref,), timestamp=self._now())

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the game engine works, and since when the adapter has been operable."""
        return EngineStatusResult(status=self._engine_status(), operable_time=self._operable_since)
