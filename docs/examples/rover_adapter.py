"""A rover that drives on a floor, and the camera on the ceiling above it."""

import asyncio
import math
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from typing import Any

import numpy as np
from openrois_media import VideoSource, main

from openrois.adapter import BadParameter, ComponentStatus, components
from openrois.catalog.system_information import EngineStatusResult, RobotPositionResult

SIZE, SCALE, STEP = (320, 240), 60, 1 / 30  # pixels, pixels in a metre, seconds
SPEED, TURN = 0.5, 1.5  # metres and radians in a second


class Rover(components.Move):
    """Drives straight on, then turns; `x` and `y` in metres, `heading` in radians."""

    x = y = heading = 0.0

    async def start(self) -> None:
        """Go `line[0]` millimetres, then turn by `line[1]` degrees."""
        if self.line is None or len(self.line) != 2:
            raise BadParameter("set line to the millimetres to go and the degrees to turn")
        way, turn = self.line[0] / 1000, math.radians(self.line[1])
        for _ in range(steps := math.ceil(abs(way) / SPEED / STEP)):
            self.x += way / steps * math.cos(self.heading)
            self.y += way / steps * math.sin(self.heading)
            await asyncio.sleep(STEP)
        for _ in range(steps := math.ceil(abs(turn) / TURN / STEP)):
            self.heading += turn / steps
            await asyncio.sleep(STEP)

    async def stop(self) -> None:
        """Stand: `start` is cancelled."""

    async def pictures(self) -> AsyncIterator[Any]:
        """Draw the floor and the rover on it, while an application watches."""
        rows, columns = np.indices((SIZE[1], SIZE[0]))
        floor = np.array([(120, 130, 140), (150, 160, 170)], np.uint8)[(rows // SCALE + columns // SCALE) % 2]
        across, ahead = (columns - SIZE[0] / 2) / SCALE, (SIZE[1] / 2 - rows) / SCALE
        while True:
            picture = floor.copy()
            picture[np.hypot(across - self.x, ahead - self.y) < 0.2] = (40, 40, 200)
            x, y = self.x + 0.15 * math.cos(self.heading), self.y + 0.15 * math.sin(self.heading)
            picture[np.hypot(across - x, ahead - y) < 0.07] = (255, 255, 255)
            yield picture
            await asyncio.sleep(STEP)


class Information(components.SystemInformation):
    """Where the rover is."""

    async def robot_position(self) -> RobotPositionResult:
        """Return the place and the heading."""
        place = f"{rover.x:.3f},{rover.y:.3f},{rover.heading:.3f}"
        return RobotPositionResult(position_data=(place,), robot_ref=("rover_1",), timestamp=datetime.now(UTC))

    async def engine_status(self) -> EngineStatusResult:
        """Return READY: nothing here can fail."""
        return EngineStatusResult(status=ComponentStatus.READY)


if __name__ == "__main__":
    rover = Rover()
    main(rover, Information(), engine_id="rover_1", streams={"camera": VideoSource(rover.pictures, size=SIZE)})
