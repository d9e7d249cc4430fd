"""Locomotion of the figure: one motion at a time commands the game engine to walk, and awaits the outcome."""

import asyncio
import logging
import secrets
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from math import hypot
from types import TracebackType
from typing import Final, Literal, Self, TypeAlias

from openrois_streaming.clock import MediaClock

from openrois.aio.tasks import TaskScope
from openrois.errors import Aborted, ComponentFailed, RoISError
from openrois_body.messages import (
    Command,
    Completed,
    Drive,
    Event,
    Halt,
    LinkError,
    Place,
    Reached,
    Walk,
    Waypoint,
)

__all__ = ["TOP_SPEED", "Ended", "Legs", "Motion"]

TOP_SPEED: Final = 2.0
"""Metres a second that a body can reach unless it says otherwise."""

_log = logging.getLogger(__name__)

Ended: TypeAlias = Literal["OK", "ABORT", "INTERRUPTED"]
"""The end of a walk: at its last point, aborted by the game engine, or interrupted by the adapter."""

_PATIENCE: Final = 10.0
_PATIENCE_PER_POINT: Final = 3.0
"""Seconds that a walk may take beside twice its length over its speed; then the game engine counts as hung."""


@dataclass(slots=True)
class _Walking:
    """A walk whose end a task awaits."""

    id: str
    reached: Callable[[int], None]
    ended: "asyncio.Future[Ended]"

    def finish(self, how: Ended) -> None:
        if not self.ended.done():
            self.ended.set_result(how)

    def fail(self, error: RoISError) -> None:
        if not self.ended.done():
            self.ended.set_exception(error)


class Motion:
    """One motion of the figure: `async with` it, in the task that makes it.

    An end from outside (another motion, an operator that drives, a lost engine, `fail`) cancels the block, which raises
    the reason. When the block is left the figure stands.

    Args:
        legs: the figure's legs.
        name: of the motion's component, for the reason of a motion that it replaces.

    Raises:
        RoISError: out of the block, the reason of an end from outside.
    """

    def __init__(self, legs: "Legs", name: str) -> None:
        self._legs = legs
        self.name = name
        self._task: asyncio.Task[object] | None = None
        self._cancelling = 0
        self._error: RoISError | None = None
        self._walking: _Walking | None = None
        self._under_way = ""

    async def __aenter__(self) -> Self:
        self._task = asyncio.current_task()
        assert self._task is not None
        self._cancelling = self._task.cancelling()
        self._legs.begin(self)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        task, self._task = self._task, None
        self.halt()
        self._legs.leave(self)
        if self._error is not None:
            assert task is not None
            # As asyncio.timeout does it: where the task is cancelled by others, too, that counts.
            if task.uncancel() <= self._cancelling and isinstance(error, asyncio.CancelledError):
                raise self._error from error

    async def walk(
        self, path: Sequence[Waypoint], speed: float, reached: Callable[[int], None] = lambda _index: None
    ) -> Ended:
        """Walk straight from point to point, and return how it ended; one walk at a time.

        Args:
            path: the points, at least one and at most `MAX_PATH`.
            speed: metres a second; the body goes no faster than it can.
            reached: called with the index of each point when the figure is there.

        Raises:
            ComponentFailed: the game engine is gone, has no figure that walks, cannot go there, or does not do it in
                about twice the time that it should take.
        """
        loop = asyncio.get_running_loop()
        speed = min(speed, self._legs.top_speed)
        walking = _Walking(secrets.token_hex(8), reached, loop.create_future())
        self._legs.send(Walk(walking.id, tuple(path), speed))
        self._walking, self._under_way = walking, walking.id
        try:
            async with TaskScope() as tasks:
                tasks.start(self._lose_patience(walking, _longest(self._legs.place(), path, speed)))
                return await walking.ended
        finally:
            self._walking = None

    def interrupt(self) -> None:
        """End `walk` early; the figure goes on until the next walk replaces this one, or the block is left."""
        if self._walking is not None:
            self._walking.finish("INTERRUPTED")

    def halt(self) -> None:
        """Let the figure stand still now, and end `walk` early."""
        if self._under_way:
            self._under_way = ""
            with suppress(ComponentFailed):
                self._legs.send(Halt())
        self.interrupt()

    def fail(self, error: RoISError) -> None:
        """Let the figure stand still now, and end the motion with this error."""
        self.halt()
        if self._error is None and self._task is not None:
            self._error = error
            self._task.cancel()

    def handle_event(self, event: Event) -> None:
        """Handle an event of the game engine."""
        match event:
            case Reached(id=walk_id, index=index) if walk_id == self._under_way and self._walking is not None:
                self._walking.reached(index)
            case Completed(id=walk_id, status=status, reason=reason) if walk_id == self._under_way:
                self._under_way = ""
                if self._walking is None:
                    return
                if status == "ERROR":
                    self._walking.fail(ComponentFailed(reason or "the body cannot go there"))
                else:
                    self._walking.finish(status)

    async def _lose_patience(self, walking: _Walking, seconds: float) -> None:
        await self._legs.clock.sleep_until(self._legs.clock.now() + seconds)
        walking.fail(ComponentFailed(f"the body has not ended a walk for {seconds:.0f} s"))


class Legs:
    """The legs of the figure in the connected game engine.

    One motion at a time: a new one ends the one before it, which fails with `Aborted` and a sentence that says why.
    An operator that drives ends every motion, again with each `drive`: driving comes first.

    Args:
        send: sends a command to the game engine.
        walks: returns whether the game engine said that its figure walks.
        place: returns where the figure is, if that is known.
        clock: the media clock.
        top_speed: metres a second that the body can reach.

    Raises:
        LinkError: out of `send`, while no game engine is connected.
    """

    def __init__(
        self,
        send: Callable[[Command], None],
        walks: Callable[[], bool],
        place: Callable[[], Place | None],
        clock: MediaClock,
        top_speed: float = TOP_SPEED,
    ) -> None:
        self._send = send
        self._walks = walks
        self.place = place
        self.clock = clock
        self.top_speed = top_speed
        self._motion: Motion | None = None

    @property
    def can_walk(self) -> bool:
        """Whether the game engine that is connected has a figure that walks."""
        return self._walks()

    def motion(self, name: str) -> Motion:
        """Return a motion; entering its block ends the motion before it."""
        return Motion(self, name)

    def drive(self, ahead: float, left: float, turn: float) -> None:
        """Go with this velocity for half a second at most: m/s ahead and to the left, rad/s to the left.

        Raises:
            ComponentFailed: the game engine is gone, or has no figure that walks.
        """
        self._replace("an operator drives the body by hand")
        self.send(Drive(ahead, left, turn))

    def halt(self, reason: str) -> None:
        """Let the figure stand still now; a motion fails with the reason. Never raises.

        Args:
            reason: a sentence for a person.
        """
        self._replace(reason)
        with suppress(ComponentFailed):
            self.send(Halt())

    def stand(self) -> None:
        """Let a figure without a motion stand still now: it may move by itself, to face a viewer. Never raises."""
        if self._motion is None:
            with suppress(ComponentFailed):
                self.send(Halt())

    def handle_event(self, event: Event) -> None:
        """Handle an event of the game engine."""
        if self._motion is not None:
            self._motion.handle_event(event)

    def engine_lost(self) -> None:
        """Fail the motion: the game engine is disconnected."""
        if self._motion is not None:
            self._motion.fail(ComponentFailed("the body is disconnected; try again when it is back"))

    def begin(self, motion: Motion) -> None:
        """Make a motion the current one; called by the motion."""
        self._replace(f"{motion.name} has the body now")
        self._motion = motion

    def leave(self, motion: Motion) -> None:
        """Remove a motion that has ended; called by the motion."""
        if self._motion is motion:
            self._motion = None

    def send(self, command: Command) -> None:
        """Send a command; called by the motion.

        Raises:
            ComponentFailed: the game engine is gone, or has no figure that walks.
        """
        if not self._walks():
            raise ComponentFailed("no body that moves is connected; the HELLO of a game engine has to say `walks`")
        try:
            self._send(command)
        except LinkError as error:
            raise ComponentFailed(str(error)) from error

    def _replace(self, reason: str) -> None:
        if self._motion is not None:
            _log.info("%s ends: %s", self._motion.name, reason)
            self._motion.fail(Aborted(f"{self._motion.name} was ended: {reason}"))
            self._motion = None


def _longest(start: Place | None, path: Sequence[Waypoint], speed: float) -> float:
    """Return the seconds after which the engine counts as hung."""
    points = [(start.x, start.y)] if start is not None else []
    points += [(at.x, at.y) for at in path]
    length = sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points))
    return _PATIENCE + _PATIENCE_PER_POINT * len(path) + 2 * length / speed
