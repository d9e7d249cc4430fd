"""SystemInformation: where the body stands, and whether its engine works (component 1 of the standard)."""

import time
from collections.abc import Callable
from datetime import UTC, datetime
from math import pi
from typing import Final

from openrois.adapter import ComponentStatus, components
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult
from openrois_body.messages import Place

__all__ = ["SystemInformation"]

_BEGINNING: Final = Place(0.0, 0.0, -pi / 2)
"""The place where a figure begins: in the middle, facing the viewer."""


class SystemInformation(components.SystemInformation, function="sensing"):
    """Reports the body's place and status from its game engine; without RoIS_Common, as the standard's profile.

    Args:
        body_ref: the id by which the body is known, the only entry of `robot_ref`.
        engine_status: returns the status of the game engine.
        place: returns where the figure is; None where the engine does not report it: then it is where it began.
        wall_clock: epoch seconds.
    """

    def __init__(
        self,
        body_ref: str,
        engine_status: Callable[[], ComponentStatus],
        place: Callable[[], Place | None] = lambda: None,
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        super().__init__()
        self._body_ref = body_ref
        self._engine_status = engine_status
        self._place = place
        self._wall_clock = wall_clock
        self._operable_since = self._now()

    def _now(self) -> datetime:
        return datetime.fromtimestamp(self._wall_clock(), UTC)

    async def robot_position(self) -> RobotPositionResult:
        """Return the moment, the body and its place `x,y,th` in its scene."""
        place = self._place() or _BEGINNING
        position = f"{place.x:.3f},{place.y:.3f},{place.th:.4f}"
        return RobotPositionResult(position_data=(position,), robot_ref=(self._body_ref,), timestamp=self._now())

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the game engine works, and since when the adapter has been operable."""
        return EngineStatusResult(status=self._engine_status(), operable_time=self._operable_since)
