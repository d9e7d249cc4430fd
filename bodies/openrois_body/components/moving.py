"""The base of the moving components: one motion at a time, its time limit, and RoIS_Common."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from openrois.adapter import ComponentFailed, ComponentStatus
from openrois.aio.tasks import TaskScope
from openrois.errors import TimedOut
from openrois_body.messages import Place
from openrois_body.motion.legs import Legs, Motion
from openrois_body.motion.wayfinding import Ways
from openrois_body.motion.world import World

__all__ = ["Figure", "Moving"]

_MILLISECOND = 0.001


@dataclass(frozen=True, slots=True)
class Figure:
    """The figure and its scene, shared by all moving components.

    Attributes:
        legs: move it.
        world: its scene.
        ways: plans ways through the scene.
        engine_status: returns the status of the game engine.
    """

    legs: Legs
    world: World
    ways: Ways
    engine_status: Callable[[], ComponentStatus]

    def status(self) -> ComponentStatus:
        """Return the status of the game engine; ERROR where its figure does not walk, or its place is not known yet."""
        ready = self.legs.can_walk and self.world.place is not None
        return self.engine_status() if ready else ComponentStatus.ERROR

    def place(self) -> Place:
        """Return where the figure is.

        Raises:
            ComponentFailed: the game engine has not reported a place.
        """
        if self.world.place is None:
            raise ComponentFailed("the body has not reported where it is; a game engine has to send `place`")
        return self.world.place

    async def rest(self, seconds: float) -> None:
        """Wait for so many seconds."""
        await self.legs.clock.sleep_until(self.legs.clock.now() + seconds)


class Moving:
    """Mixin that makes a component move the figure; it stands before the standard's base class.

    Args:
        figure: the figure that it moves.
    """

    name: str

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self.figure = figure
        self._clock = figure.legs.clock
        self._motion: Motion | None = None
        self._going = asyncio.Event()
        self._stood = 0.0
        self._stands_since = 0.0

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine; ERROR while its figure does not walk, or its place is not known."""
        return self.figure.status()

    async def stop(self) -> None:
        """Let the figure stand still; `start` ends with ABORT. A motion of another component goes on."""
        self.figure.legs.stand()

    async def suspend(self) -> None:
        """Let the figure stand still until `resume`; the time limit waits. Without a running motion nothing happens."""
        if self._motion is not None and self._going.is_set():
            self._going.clear()
            self._stands_since = self._clock.now()
            self._motion.halt()

    async def resume(self) -> None:
        """Go on."""
        if not self._going.is_set():
            self._stood += self._clock.now() - self._stands_since
            self._going.set()

    @asynccontextmanager
    async def moving(self, limit: int | None = None) -> AsyncIterator[Motion]:
        """Hold the figure for as long as the block runs.

        Args:
            limit: the milliseconds that the block may take, without those in which it is suspended; None and 0: no end.

        Raises:
            TimedOut: the block has taken longer.
            RoISError: what else ended the motion from outside, as `Motion` says.
        """
        self._stood = 0.0
        self._going.set()
        async with self.figure.legs.motion(self.name) as motion, TaskScope() as tasks:
            if limit:
                tasks.start(self._expire(motion, limit))
            self._motion = motion
            try:
                yield motion
            finally:
                # A new start waits until this one is over: the motion is still ours.
                self._motion = None

    async def going(self) -> None:
        """Wait while the component is suspended."""
        await self._going.wait()

    @property
    def is_suspended(self) -> bool:
        """Whether the component is suspended; that may happen while a way is planned."""
        return not self._going.is_set()

    def replan(self, motion: Motion) -> None:
        """End `walk`, as the floor has changed; where planning takes long, the figure stands meanwhile."""
        if self.figure.ways.are_quick:
            motion.interrupt()
        else:
            motion.halt()

    async def _expire(self, motion: Motion, limit: int) -> None:
        began = self._clock.now()
        while (left := began + limit * _MILLISECOND + self._stood - self._clock.now()) > 0:
            await self._clock.sleep_until(self._clock.now() + left)
            await self._going.wait()
        motion.fail(TimedOut(f"{self.name} took longer than {limit} ms"))
