"""Where voices come from, as the robot's microphones tell: asked for often while a sense is active."""

import asyncio
from collections.abc import Callable
from contextlib import suppress
from math import pi
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import RoISError
from openrois.aio.listeners import Listeners
from openrois_robots.reachy.robot import Reachy

__all__ = ["Directions"]

_OFTEN: Final = 0.1
_SELDOM: Final = 2.0
"""Seconds between two questions while a sense is active, and while none is: whether there are microphones."""
_AGAIN: Final = 0.3
"""Seconds after the first question, which the daemon answers with nothing while it begins to listen."""


class Directions:
    """The directions of voices at one robot; `run` has to run.

    Args:
        robot: the robot.
        clock: the media clock.

    Attributes:
        told: called with the bearing of a voice in radians, to the right of the head's front, or None where there is
            none now; and with the time.
        is_there: whether the robot has told any.
    """

    def __init__(self, robot: Reachy, clock: MediaClock) -> None:
        self.told: Listeners[float | None, float] = Listeners()
        self.is_there = False
        self._robot = robot
        self._clock = clock
        self._listening = 0
        self._woken = asyncio.Event()
        self._asked = 0
        robot.link.changed.add(self._on_link_changed)

    def listen(self) -> Callable[[], None]:
        """Ask often from now on; return a function that ends that."""
        self._listening += 1
        self._woken.set()

        def end() -> None:
            self._listening -= 1

        return end

    async def run(self) -> None:
        """Ask until cancelled."""
        while True:
            self._woken.clear()
            if self._robot.link.is_up:
                with suppress(RoISError):
                    await self._ask()
            pause = _OFTEN if self._listening else _AGAIN if self._asked < 2 else _SELDOM
            sleeping = asyncio.ensure_future(self._clock.sleep_until(self._clock.now() + pause))
            waking = asyncio.ensure_future(self._woken.wait())
            try:
                await asyncio.wait((sleeping, waking), return_when=asyncio.FIRST_COMPLETED)
            finally:
                sleeping.cancel()
                waking.cancel()

    async def _ask(self) -> None:
        told = await self._robot.daemon.get("/api/state/doa")
        self._asked += 1
        angle = told.get("angle") if isinstance(told, dict) else None
        self.is_there = isinstance(angle, float | int)
        bearing = None
        if isinstance(angle, float | int) and told.get("speech_detected"):
            bearing = angle - pi / 2
        if self._listening:
            self.told.notify_all(bearing, self._clock.now())

    def _on_link_changed(self) -> None:
        self.is_there, self._asked = False, 0
        self._woken.set()
