"""Players that operate the avatar without a binding: one at a time, and none while an application holds it."""

import asyncio
from collections.abc import Callable
from typing import Final, Protocol

from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import Pilot
from openrois_streaming.clock import MediaClock
from openrois_streaming.input.messages import Button, Key, Pad, State, TouchPoint
from openrois_streaming.input.messages import Message as InputMessage

from openrois_avatar.pixel_streaming.player_input import PlayerInput

__all__ = ["FIRST_PRESS", "STATE_INTERVAL", "Guest", "Guests"]

FIRST_PRESS: Final = 0.6
"""Seconds for which a press counts without a repetition: a keyboard waits as long before it repeats a key."""

STATE_INTERVAL: Final = 0.05
"""Seconds between two states that are passed on; a page sends each axis of a gamepad separately."""


class Guest(Protocol):
    """A player that operates when it is its turn."""

    def own(self, on: bool) -> None:
        """Note whether it operates from now on."""
        ...


class Guests:
    """The choice of the player that operates: the longest connected one. `run` has to run.

    Args:
        operator_control: of the bound application; while it is held no player operates.
        make_pilot: makes a pilot, which calls its argument with the reason when it stops by itself.
        clock: the media clock.
    """

    def __init__(
        self, operator_control: OperatorControl, make_pilot: Callable[[Callable[[str], None]], Pilot], clock: MediaClock
    ) -> None:
        self._operator_control = operator_control
        self._clock = clock
        self._pilot = make_pilot(self._stopped)
        self._guests: list[Guest] = []
        self._operator: Guest | None = None
        self._input: PlayerInput | None = None
        self._pressed_until = 0.0
        self._told_at = 0.0
        self._late = False
        self._news = asyncio.Event()

    def join(self, guest: Guest) -> None:
        """Add a player; a known one keeps its turn."""
        if guest not in self._guests:
            self._guests.append(guest)
        self._choose("another player operates")

    def leave(self, guest: Guest, reason: str) -> None:
        """Remove a player, if it is known."""
        if guest in self._guests:
            self._guests.remove(guest)
            self._choose(reason)

    def operate(self, guest: Guest, message: InputMessage, player_input: PlayerInput) -> bool:
        """Handle input of a player; return False if it is ignored, because it is not its turn."""
        if guest is not self._operator:
            return False
        now, self._input = self._clock.now(), player_input
        if isinstance(message, State):
            self._late = now - self._told_at < STATE_INTERVAL
            if self._late:
                self._news.set()
                return True
            self._told_at = now
        elif isinstance(message, Key | Button | TouchPoint | Pad) and _goes_down(message):
            self._pressed_until = now + FIRST_PRESS
            self._news.set()
        self._pilot.handle_input(message, player_input.held)
        return True

    async def run(self) -> None:
        """Run the dead man's switch until cancelled."""
        leave = self._operator_control.held_changed.add(
            lambda _held: self._choose("an application has bound the avatar's teleoperation")
        )
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._pilot.watch())
                group.create_task(self._repeat())
        finally:
            leave()
            self._pilot.lose("operation by players has ended")

    async def _repeat(self) -> None:
        """Repeat input that was pressed a moment ago, and pass on states that came too fast."""
        while True:
            await self._news.wait()
            now = self._clock.now()
            await self._clock.sleep_until(now + STATE_INTERVAL)
            held = self._clock.now() < self._pressed_until and self._input is not None and self._input.held.is_active
            if self._input is not None and (held or self._late):
                self._late, self._told_at = False, self._clock.now()
                self._pilot.handle_input(self._input.state(), self._input.held)
            if not held:
                self._news.clear()

    def _choose(self, reason: str) -> None:
        """Choose the player that operates now; `reason` says why it may be another one than before."""
        turn = self._guests[0] if self._guests and not self._operator_control.is_held else None
        if turn is self._operator:
            return
        before, self._operator = self._operator, turn
        self._pilot.lose(reason)
        self._rest()
        if before is not None:
            before.own(False)
        if turn is not None:
            turn.own(True)

    def _stopped(self, _reason: str) -> None:
        self._rest()

    def _rest(self) -> None:
        """Release all that is held: it has to be pressed again."""
        if self._input is not None:
            self._input.let_go()
        self._input, self._late, self._pressed_until = None, False, 0.0


def _goes_down(change: Key | Button | TouchPoint | Pad) -> bool:
    return change.down
