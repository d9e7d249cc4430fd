"""SystemInformation: where the avatar stands, and whether its engine works (component 1 of the standard)."""

import time
from collections.abc import Callable
from datetime import UTC, datetime
from math import pi
from typing import Final

from openrois.adapter import ComponentStatus, components
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult
from openrois_avatar.link.messages import Place

__all__ = ["SystemInformation"]

_BEGINNING: Final = Place(0.0, 0.0, -pi / 2)
"""Where a figure begins: in the middle, with its face to the viewer."""


class SystemInformation(components.SystemInformation, function="sensing"):
    """Answers from the game engine's connection; has no RoIS_Common, like the standard's profile.

    Args:
        avatar_ref: the id by which the avatar is known, the only entry of `robot_ref`.
        engine_status: tells whether the game engine works now.
        place: tells where the figure is; None where the game engine does not tell: then it has not left where it began.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        avatar_ref: str,
        engine_status: Callable[[], ComponentStatus],
        place: Callable[[], Place | None] = lambda: None,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__()
        self._avatar_ref = avatar_ref
        self._engine_status = engine_status
        self._place = place
        self._wall_clock = wall_clock
        self._operable_since = self._now()

    def _now(self) -> datetime:
        return datetime.fromtimestamp(self._wall_clock(), UTC)

    async def robot_position(self) -> RobotPositionResult:
        """Return the moment, the avatar and its place `x,y,th` in its scene."""
        place = self._place() or _BEGINNING
        position = f"{place.x:.3f},{place.y:.3f},{place.th:.4f}"
        return RobotPositionResult(position_data=(position,), robot_ref=(self._avatar_ref,), timestamp=self._now())

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the game engine works, and since when the adapter has been operable."""
        return EngineStatusResult(status=self._engine_status(), operable_time=self._operable_since)
