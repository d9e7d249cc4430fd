"""The simulated robot in its rooms: it takes the commands of `openrois_body.messages`, and reports its events.

Everything is driven by the clock in steps of one length, so that the same commands at the same times do the same.
"""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from math import hypot, remainder, tau
from typing import Final

from openrois_body.messages import Command, Completed, Drive, Event, Halt, Look, Place, React, Thing, Things, Walk
from openrois_body.speech_options import VoiceChoice
from openrois_streaming.clock import MediaClock

from openrois.aio.listeners import Listeners
from openrois_robots.simulated.battery import Battery, BatterySettings
from openrois_robots.simulated.drawing.view import View
from openrois_robots.simulated.driving import BaseSettings, DriveControl
from openrois_robots.simulated.physics import STEP, Physics
from openrois_robots.simulated.world.plan import Plan
from openrois_robots.simulated.world.visitor import Visitor

__all__ = ["Simulation", "SimulationSettings"]

_LONGEST: Final = 1.0
"""Most seconds of driving that are made up for, after the process was held up."""
_AHEAD: Final = 1.0
"""Metres that are looked ahead for obstacles."""
_PLACES: Final = 0.05
_THINGS: Final = 0.1
"""Seconds between two events on the robot's place, and on the things around it."""
_PAN, _TILT = 0.7, 0.35
"""Radians by which the camera turns to the side, and up or down, for the furthest gaze."""
_LEVEL: Final = -0.1
"""Radians by which the camera looks up without a gaze: a little down, so that it sees the floor ahead."""
_TICK: Final = 0.02
_IDLE: Final = 0.5
"""Seconds between two steps of the simulation while something moves, and while nothing does."""


@dataclass(frozen=True, slots=True)
class SimulationSettings:
    """What is simulated.

    Attributes:
        base: speeds of the robot.
        battery: its battery.
        visitor: whether a person walks about.
        voice: what speaks.
    """

    base: BaseSettings = field(default_factory=BaseSettings)
    battery: BatterySettings = field(default_factory=BatterySettings)
    visitor: bool = False
    voice: VoiceChoice = field(default_factory=VoiceChoice)


class Simulation:
    """A robot in its rooms; `run` has to run.

    Args:
        plan: of the rooms.
        settings: what is simulated.
        clock: drives it.
        on_event: called with each event, in `send`, `begin`, `advance` and `run`.

    Attributes:
        battery: of the robot.
        battery_changed: called when its percentage, or whether it is charged or empty, has changed.
    """

    def __init__(
        self, plan: Plan, settings: SimulationSettings, clock: MediaClock, on_event: Callable[[Event], None]
    ) -> None:
        self.plan = plan
        self.battery = Battery(settings.battery)
        self.battery_changed: Listeners[Battery] = Listeners()
        self._settings = settings
        self._clock = clock
        self._on_event = on_event
        self._base = DriveControl(settings.base)
        self._physics = Physics(plan)
        self._th = plan.start.th
        self._gaze = 0.0, 0.0
        self._now = clock.now()
        self._visitor = Visitor(plan.visitor.place, plan.round) if settings.visitor else None
        self._woken = asyncio.Event()
        self._told_place: tuple[Place | None, float] = None, 0.0
        self._told_things: tuple[tuple[Thing, ...], float] = (), 0.0
        self._told_battery = -1, False, False

    @property
    def place(self) -> Place:
        """Where the robot is."""
        x, y = self._physics.at
        return Place(x, y, self._th)

    @property
    def things(self) -> tuple[Thing, ...]:
        """Everything that the robot knows around it."""
        if self._visitor is None:
            return self.plan.things
        name, at = self.plan.visitor.name, self._visitor.place
        return (*self.plan.things, Thing(name, "person", at.x, at.y, at.th, name))

    def view(self) -> View:
        """Let time pass up to now, and return what the robot's camera sees."""
        self.advance()
        at, (x, y) = self.place, self._gaze
        camera = Place(at.x, at.y, remainder(at.th - _PAN * x, tau))
        if self._visitor is None:
            return View(camera, _LEVEL + _TILT * y)
        return View(camera, _LEVEL + _TILT * y, self._visitor.place, self._visitor.walked)

    def begin(self) -> None:
        """Report the floor, the place, and what is around."""
        self._on_event(self.plan.floor)
        self._report()

    def send(self, command: Command) -> None:
        """Obey a command; those for a mouth, a game or a scene have no effect on a robot that has none."""
        self.advance()
        match command:
            case Walk():
                self._walk(command)
            case Drive() if not self.battery.is_empty:
                self._base.drive(command, self._now)
            case Drive() | Halt():
                self._base.end_motion("ABORT")
            case Look(x=x, y=y):
                self._gaze = x, y
            case React():
                self._base.news.append(Completed(command.id, "ERROR", "the robot has no reactions"))
        # What became of it is told later: the sender has to know first that it was sent.
        self._woken.set()

    def push_to_dock(self) -> None:
        """Let a person push the robot onto its charging mat, in no time."""
        self.advance()
        self._base.end_motion("ABORT", "the robot was pushed to its dock")
        self._physics.put(self.plan.mat.x, self.plan.mat.y)
        self._report_place()
        self._woken.set()

    async def run(self) -> None:
        """Let time pass until cancelled."""
        while True:
            self.advance()
            self._woken.clear()
            if self._is_still:
                await self._rest()
            else:
                await self._clock.sleep_until(self._clock.now() + _TICK)

    def advance(self) -> None:
        """Let time pass up to now, in steps of `STEP`."""
        now = self._clock.now()
        if now - self._now > _LONGEST or self._is_still:
            # Nothing moves meanwhile, or the process was held up: the battery knows how long.
            idle = (now - self._now) if self._is_still else now - self._now - _LONGEST
            steps = max(0, int(idle / STEP))
            self._drain(steps * STEP)
            self._now += steps * STEP
        while self._now + STEP <= now:
            self._step()
        self._tell_news()
        self._report()

    @property
    def _is_still(self) -> bool:
        return self._base.is_at_rest and self._visitor is None

    async def _rest(self) -> None:
        waking = asyncio.ensure_future(self._woken.wait())
        passing = asyncio.ensure_future(self._clock.sleep_until(self._clock.now() + _IDLE))
        try:
            await asyncio.wait({waking, passing}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            waking.cancel()
            passing.cancel()

    def _walk(self, walk: Walk) -> None:
        end = walk.path[-1]
        refusal = self.battery.refusal
        if refusal and (self.battery.is_empty or not self.plan.mat.holds(end.x, end.y)):
            self._base.end_motion("ABORT")
            self._base.news.append(Completed(walk.id, "ERROR", refusal))
        else:
            self._base.walk(walk, self.place, self._now)

    def _step(self) -> None:
        """Let one step pass."""
        if self._visitor is not None:
            self._visitor.advance(STEP, self._physics.at)
            self._physics.place_visitor(self._visitor.place)
        going = self._base.velocity
        place = self.place
        velocity = self._base.choose(place, self._now, STEP, self._room_ahead(going.x, going.y))
        self._physics.step(velocity.x, velocity.y)
        self._th = remainder(self._th + velocity.turn * STEP, tau)
        self._now += STEP
        self._drain(STEP, velocity.speed / self._settings.base.speed)
        self._tell_news()

    def _room_ahead(self, x: float, y: float) -> float:
        return self._physics.room(x, y, _AHEAD) if hypot(x, y) > 0.01 else _AHEAD

    def _drain(self, seconds: float, effort: float = 0.0) -> None:
        self.battery.advance(seconds, effort, self.plan.mat.holds(*self._physics.at))
        if self.battery.is_empty:
            self._base.end_motion("ERROR", self.battery.refusal)

    def _tell_news(self) -> None:
        news, self._base.news = self._base.news, []
        for event in news:
            if isinstance(event, Completed):
                # What it causes begins where the robot is.
                self._report_place()
            self._on_event(event)

    def _report(self) -> None:
        """Report what has changed, as often as it may be."""
        place, at = self._told_place
        if self.place != place and self._now >= at + _PLACES:
            self._report_place()
        things, at = self._told_things
        if self._now >= at + _THINGS and (now := self.things) != things:
            self._told_things = now, self._now
            self._on_event(Things(now))
        level = self.battery.percent, self.battery.is_charging, self.battery.is_empty
        if level != self._told_battery:
            self._told_battery = level
            self.battery_changed.notify_all(self.battery)

    def _report_place(self) -> None:
        self._told_place = self.place, self._now
        self._on_event(self.place)
