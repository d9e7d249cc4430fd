"""A game engine without pictures: a figure that walks by kinematics alone, and the moving components that use it.

Every command and event goes through the JSON of the engine link.
"""

import asyncio
import json
from collections.abc import Callable
from math import atan2, cos, hypot, pi, remainder, sin, tau
from typing import Any

from openrois_avatar.link.messages import Command, Event, Idle, command_from_json, event_from_json
from openrois_body.components.follow import Follow
from openrois_body.components.move import Move
from openrois_body.components.moving import Figure
from openrois_body.components.navigation import Navigation
from openrois_body.messages import (
    Completed,
    Drive,
    Floor,
    Halt,
    LinkError,
    Place,
    Reached,
    Thing,
    Things,
    Walk,
)
from openrois_body.motion.legs import Legs
from openrois_body.motion.wayfinding import Ways
from openrois_body.motion.world import World

from openrois.types.codes import ComponentStatus
from tests.support.streaming import VirtualClock, settle

STEP = 0.05
TURN = pi
"""Radians a second."""


class Walker:
    """The engine's side: goes straight to each point of a path, and turns on the spot."""

    def __init__(self, tell: Callable[[Event], None]) -> None:
        self._tell = tell
        self.x, self.y, self.th = 0.0, 0.0, 0.0
        self.walks = True
        self.connected = True
        self.deaf = False
        self.heard: list[Command] = []
        self.track: list[tuple[float, float]] = [(0.0, 0.0)]
        self._walk: Walk | None = None
        self._next = 0
        self._drive = Drive(0, 0, 0)
        self._drives_for = 0.0

    def send(self, command: Command) -> None:
        if not self.connected:
            raise LinkError("the engine is gone")
        command = command_from_json(json.loads(json.dumps(command.to_json())))
        self.heard.append(command)
        match command:
            case _ if self.deaf:
                pass
            case Walk():
                self.break_off()
                self._walk, self._next = command, 0
            case Halt():
                self.break_off()
                self._drives_for = 0.0
            case Drive():
                self.break_off()
                self._drive, self._drives_for = command, 0.5

    def tell(self, event: Event) -> None:
        self._tell(event_from_json(json.loads(json.dumps(event.to_json()))))

    def tell_place(self) -> None:
        self.tell(Place(self.x, self.y, remainder(self.th, tau)))

    def break_off(self) -> None:
        """End the walk before its end, as by a stop or something in the way."""
        if self._walk is not None:
            walk, self._walk = self._walk, None
            self.tell(Completed(walk.id, "ABORT"))

    def refuse(self) -> None:
        assert self._walk is not None
        walk, self._walk = self._walk, None
        self.tell(Completed(walk.id, "ERROR"))

    @property
    def moves(self) -> bool:
        return self._walk is not None or self._drives_for > STEP / 2

    def step(self) -> None:
        """Let one twentieth of a second pass."""
        if self._drives_for > STEP / 2:
            self._drives_for -= STEP
            ahead, left = self._drive.ahead * STEP, self._drive.left * STEP
            self.x += ahead * cos(self.th) - left * sin(self.th)
            self.y += ahead * sin(self.th) + left * cos(self.th)
            self.th += self._drive.turn * STEP
            self.tell_place()
        elif self._walk is not None:
            self._step_of_walk(self._walk)
        self.track.append((self.x, self.y))

    def _step_of_walk(self, walk: Walk) -> None:
        left = STEP
        while left > 0 and self._walk is walk:
            at = walk.path[self._next]
            away = hypot(at.x - self.x, at.y - self.y)
            th = at.th if at.th is not None else atan2(at.y - self.y, at.x - self.x) if away > 1e-6 else self.th
            turn = remainder(th - self.th, tau)
            if abs(turn) > 1e-6:
                now = min(abs(turn), left * TURN)
                self.th += now if turn > 0 else -now
                left -= now / TURN
            elif away > 1e-6:
                now = min(away, left * walk.speed)
                self.x += (at.x - self.x) * now / away
                self.y += (at.y - self.y) * now / away
                left -= now / walk.speed
                self.track.append((self.x, self.y))
            else:
                self._arrive(walk)
        self.tell_place()

    def _arrive(self, walk: Walk) -> None:
        self.tell(Reached(walk.id, self._next))
        self._next += 1
        if self._next == len(walk.path):
            self._walk = None
            self.tell(Completed(walk.id, "OK"))


class Walking:
    """The adapter's side over such an engine: a world, legs, and the components."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.world = World("avatar")
        self.engine = Walker(self._take)
        self.legs = Legs(
            self.engine.send,
            lambda: self.engine.connected and self.engine.walks,
            lambda: self.world.place,
            self.clock,
        )
        figure = Figure(self.legs, self.world, Ways(self.world), self.status)
        self.navigation, self.move, self.follow = Navigation(figure), Move(figure), Follow(figure)
        self.components = (self.navigation, self.move, self.follow)
        self.engine.tell_place()

    def status(self) -> ComponentStatus:
        return ComponentStatus.READY if self.engine.connected else ComponentStatus.ERROR

    def _take(self, event: Event) -> None:
        assert not isinstance(event, Idle)
        self.world.handle_event(event)
        self.legs.handle_event(event)

    def build(self, floor: Floor) -> None:
        self.engine.tell(floor)

    def populate(self, *things: Thing) -> None:
        self.engine.tell(Things(things))

    def lose(self) -> None:
        """The engine dies."""
        self.engine.connected = False
        self.legs.engine_lost()
        self.world.clear()

    async def run(self, seconds: float) -> None:
        """Let engine and adapter live for so long."""
        for _ in range(round(seconds / STEP)):
            await settle()
            self.engine.step()
            await self.clock.advance(STEP)
        await settle()

    async def run_until(self, done: "asyncio.Future[Any]", seconds: float = 60.0) -> None:
        """Let them live until something has happened.

        Raises:
            TimeoutError: it has not.
        """
        for _ in range(round(seconds / STEP)):
            await self.run(STEP)
            if done.done():
                return
        raise TimeoutError(f"not within {seconds} s")
