"""The motions of the robot, one at a time: a stream of targets, fifty a second, and none that is far from the last one.

The daemon's own tasks are not used: they go on when this process dies, fight each other, and end with success when they
are stopped. A target is reached within one control step, so that the robot stands when the stream ends.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentFailed, OutOfResources, RoISError
from openrois.errors import Aborted
from openrois_robots.reachy.postures.follower import Follower
from openrois_robots.reachy.postures.gestures import Frame, turned
from openrois_robots.reachy.postures.limits import STEP, MotionLimits
from openrois_robots.reachy.postures.posture import NEUTRAL, Posture, apart, turned_away
from openrois_robots.reachy.robot import Reachy

__all__ = ["Motion", "MotionFigures"]

_log = logging.getLogger(__name__)

_YAW, _PITCH = 0.9, 0.5
"""Radians of the head for the furthest gaze."""
_ELSEWHERE: Final = 0.05
"""Radians from the last target from which on the robot was moved by others, and is followed from where it is."""
_THERE: Final = 0.08
"""Radians from the last target of a motion within which it has arrived: motors give way a little under the head."""
_ARRIVING: Final = 1.0
"""Seconds that it has for that."""
_LAGGING: Final = 0.4
"""Radians behind the targets from which on the robot does not follow them."""
_PATIENCE: Final = 0.5
"""Seconds for which it may lag, or tell no posture."""


@dataclass(slots=True)
class MotionFigures:
    """Counts since the adapter began.

    Attributes:
        targets: sent to the daemon.
        stops: the daemon's own stop, called.
        unfollowed: motions that ended because the robot did not follow.
    """

    targets: int = 0
    stops: int = 0
    unfollowed: int = 0


@dataclass(eq=False, slots=True)
class _Performing:
    """A motion of a component.

    Attributes:
        owner: name of the component.
        doing: what the robot does, for sentences: `nod`.
        frames: that are left, the first is approached.
        ended: how it ended.
        since: when the first frame was reached; None: it was not yet.
    """

    owner: str
    doing: str
    frames: deque[Frame]
    ended: "asyncio.Future[None]" = field(default_factory=lambda: asyncio.get_running_loop().create_future())
    since: float | None = None

    def finish(self, error: RoISError | None) -> None:
        """End it, once."""
        if self.ended.done():
            return
        if error is None:
            self.ended.set_result(None)
        else:
            self.ended.set_exception(error)
            # It may be that nothing waits for it any more.
            self.ended.exception()


class Motion:
    """Moves one robot; `run` has to run.

    A motion begins with the neutral posture, and ends the one before it. A gaze is followed when no motion is left.

    Args:
        robot: the robot.
        limits: highest speeds.
        clock: the media clock.
    """

    def __init__(self, robot: Reachy, limits: MotionLimits, clock: MediaClock) -> None:
        self.figures = MotionFigures()
        self._robot = robot
        self._clock = clock
        self._follower = Follower(limits)
        self._performing: _Performing | None = None
        self._goal: Posture | None = None
        """Where the robot looks, or comes to rest, when no motion is left; None: it stands."""
        self._lagging_since: float | None = None
        self._woken = asyncio.Event()

    @property
    def posture(self) -> Posture:
        """The posture that the robot has, as far as it has told, or was told to take."""
        seen = self._robot.seen
        if seen is not None and apart(seen.posture, self._follower.posture) > _ELSEWHERE:
            return seen.posture
        return self._follower.posture

    @property
    def target(self) -> Posture:
        """The last target."""
        return self._follower.posture

    async def run(self) -> None:
        """Move the robot until cancelled; then it stands."""
        while True:
            await self._woken.wait()
            self._woken.clear()
            try:
                await self._stream()
            except RoISError as error:
                self._fail(error)

    def turn_eyes(self, x: float, y: float) -> None:
        """Look somewhere, from -1 (the viewer's left, down) to 1; while a motion runs, when it has ended.

        Raises:
            ComponentFailed: the robot does not move.
        """
        self._require_motors()
        self._goal = replace(NEUTRAL, yaw=_YAW * x, pitch=-_PITCH * y)
        self._woken.set()

    async def perform(self, owner: str, doing: str, frames: Iterable[Frame], turn: float = 0.0) -> None:
        """Go through key frames, and return when the robot tells that it has got to the last one.

        Args:
            owner: name of the component, for `stop`.
            doing: what the robot does, for sentences: `nod`.
            frames: after the neutral one, with the body ahead; the body stays as it is turned.
            turn: radians by which the body turns first, to the left.

        Raises:
            OutOfResources: another program moves the robot.
            Aborted: `stop` or another motion ended it.
            ComponentFailed: the robot did not get there, or was lost; the sentence says why.
        """
        await self._robot.link.during(self._perform(owner, doing, tuple(frames), turn))

    async def stop(self, owner: str, reason: str) -> None:
        """End what a component lets the robot do, and the gaze; the motion of another component goes on.

        The daemon's own stop is called too: it ends the tasks of other programs.

        Raises:
            ComponentFailed: the daemon cannot be reached.
        """
        performing = self._performing
        if performing is not None and performing.owner != owner:
            return
        if performing is not None:
            performing.finish(Aborted(reason))
        self._halt()
        await self._robot.socket.send_message({"type": "stop_move"})
        self.figures.stops += 1

    async def _perform(self, owner: str, doing: str, frames: tuple[Frame, ...], turn: float) -> None:
        self._require_motors()
        if await self._robot.daemon.get("/api/move/running"):
            raise OutOfResources("another program moves the robot: it takes no other motion until that has ended")
        if self._performing is not None:
            self._performing.finish(Aborted(f"{owner} has begun to {doing}"))
        body = self.posture.body
        path = [turned(Frame(NEUTRAL), body), *(turned(frame, body + turn) for frame in frames)]
        performing = _Performing(owner, doing, deque(path))
        self._performing, self._goal = performing, None
        self._woken.set()
        try:
            await asyncio.wait((performing.ended,))
            performing.ended.result()
        finally:
            if self._performing is performing:
                self._halt()

    def _require_motors(self) -> None:
        if problem := self._robot.motion_problem():
            raise ComponentFailed(problem)

    def _halt(self) -> None:
        """Come to rest, as soon as the limits allow."""
        self._performing = None
        self._goal = None if self._follower.is_still else self._follower.rest()
        self._woken.set()

    def _fail(self, error: RoISError) -> None:
        _log.warning("the robot is not moved: %s", error)
        if self._performing is not None:
            self._performing.finish(error)
        self._performing = self._goal = None
        self._follower.restart(self._follower.posture)

    async def _stream(self) -> None:
        """Send targets until the robot stands where it is to be."""
        self._begin()
        while self._performing is not None or self._goal is not None:
            begun = self._clock.now()
            self._robot.posture_told.clear()
            await self._send_next(begun)
            # Not by a fixed beat: of targets that come late the daemon would take several at once, and jump. So none is
            # sent sooner than a step after the last one, or before the robot has told a posture since then.
            await self._clock.sleep_until(begun + STEP)
            await self._next_posture()

    def _begin(self) -> None:
        """Begin where the robot is: others may have moved it."""
        self._lagging_since = None
        self._follower.restart(self.posture)

    async def _send_next(self, now: float) -> None:
        performing, wanted = self._performing, self._goal
        if performing is not None:
            goal, pace = performing.frames[0].posture, performing.frames[0].pace
        else:
            assert wanted is not None
            goal, pace = replace(wanted, body=self._follower.posture.body), 1.0
        target = self._follower.step(goal, pace)
        message = {"type": "set_full_target", "head": target.matrix, "antennas": target.antennas}
        await self._robot.socket.send_message({**message, "body_yaw": target.body})
        self.figures.targets += 1
        self._judge(now, target)
        if not self._follower.is_at(goal):
            return
        if performing is not None:
            self._advance(performing, now, target)
        elif self._goal is wanted:
            self._goal = None

    async def _next_posture(self) -> None:
        """Wait until the robot has told a posture; raises `ComponentFailed` where none comes for too long."""
        try:
            async with asyncio.timeout(_PATIENCE):
                await self._robot.posture_told.wait()
        except TimeoutError:
            raise ComponentFailed(f"the robot has told no posture for {_PATIENCE:g} s") from None

    def _judge(self, now: float, target: Posture) -> None:
        """Raise `ComponentFailed` where the robot has not followed for a while, or cannot."""
        self._require_motors()
        seen = self._robot.seen
        if seen is None or turned_away(seen.posture, target) <= _LAGGING:
            self._lagging_since = None
            return
        if self._lagging_since is None:
            self._lagging_since = now
        if now - self._lagging_since > _PATIENCE:
            self.figures.unfollowed += 1
            raise ComponentFailed("the robot does not follow: another program moves it, or something holds it")

    def _advance(self, performing: _Performing, now: float, target: Posture) -> None:
        """Go on to the next frame, or end, when the present one was kept for as long as it is to be."""
        if performing.since is None:
            performing.since = now
        kept = now - performing.since
        if kept < performing.frames[0].hold:
            return
        if len(performing.frames) > 1:
            performing.frames.popleft()
            performing.since = None
            return
        seen = self._robot.seen
        off = _THERE + 1 if seen is None else turned_away(seen.posture, target)
        if off <= _THERE:
            performing.finish(None)
        elif kept - performing.frames[0].hold > _ARRIVING:
            performing.finish(ComponentFailed(f"the robot did not {performing.doing}: it is {off:.2f} rad off"))
        if performing.ended.done() and self._performing is performing:
            self._performing = None
