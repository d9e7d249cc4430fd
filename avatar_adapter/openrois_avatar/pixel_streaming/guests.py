"""Players that operate the avatar without a binding: one of them at a time, and none while an application holds it."""

import asyncio
from collections.abc import Callable
from typing import Final, Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.input.messages import Button, Key, Pad, State, TouchPoint
from openrois_streaming.input.messages import Message as InputMessage

from openrois_avatar.pixel_streaming.hands import Hands
from openrois_avatar.teleoperation.pilot import Pilot
from openrois_avatar.teleoperation.seat import Seat

__all__ = ["FIRST_PRESS", "STATE_INTERVAL", "Guest", "Guests"]

FIRST_PRESS: Final = 0.6
"""Seconds for which a press counts though nothing follows it: so long a keyboard waits before it repeats a key."""

STATE_INTERVAL: Final = 0.05
"""Seconds between two states that are passed on; a page tells each axis of a gamepad by itself."""


class Guest(Protocol):
    """A player that may operate when it is its turn."""

    def own(self, on: bool) -> None:
        """It is its turn from now on, or not any more."""
        ...


class Guests:
    """Who of the players operates: the one that has been there longest. `run` has to run meanwhile.

    Args:
        seat: of who operates by right; while it is held no player operates.
        make_pilot: makes what operates, of what it tells why it stopped by itself.
        clock: the media clock.
    """

    def __init__(self, seat: Seat, make_pilot: Callable[[Callable[[str], None]], Pilot], clock: MediaClock) -> None:
        self._seat = seat
        self._clock = clock
        self._pilot = make_pilot(self._stopped)
        self._guests: list[Guest] = []
        self._operator: Guest | None = None
        self._hands: Hands | None = None
        self._pressed_until = 0.0
        self._told_at = 0.0
        self._late = False
        self._news = asyncio.Event()

    def join(self, guest: Guest) -> None:
        """A player is there; one that was there already keeps its turn."""
        if guest not in self._guests:
            self._guests.append(guest)
        self._choose("another player operates")

    def leave(self, guest: Guest, reason: str) -> None:
        """A player is gone, or its data channel; one that is not there is fine."""
        if guest in self._guests:
            self._guests.remove(guest)
            self._choose(reason)

    def operate(self, guest: Guest, message: InputMessage, hands: Hands) -> bool:
        """A player does something; False if nothing comes of it, because it is not its turn."""
        if guest is not self._operator:
            return False
        now, self._hands = self._clock.now(), hands
        if isinstance(message, State):
            self._late = now - self._told_at < STATE_INTERVAL
            if self._late:
                self._news.set()
                return True
            self._told_at = now
        elif isinstance(message, Key | Button | TouchPoint | Pad) and _goes_down(message):
            self._pressed_until = now + FIRST_PRESS
            self._news.set()
        self._pilot.take(message, hands.held)
        return True

    async def run(self) -> None:
        """Keep the dead man's switch, for ever."""
        leave = self._seat.held.add(lambda _held: self._choose("an application has bound the avatar's teleoperation"))
        try:
            async with asyncio.TaskGroup() as group:
                group.create_task(self._pilot.watch())
                group.create_task(self._repeat())
        finally:
            leave()
            self._pilot.lose("no player is to operate any more")

    async def _repeat(self) -> None:
        """Tell again what is held since a moment ago, and what came faster than it is passed on."""
        while True:
            await self._news.wait()
            now = self._clock.now()
            await self._clock.sleep_until(now + STATE_INTERVAL)
            held = self._clock.now() < self._pressed_until and self._hands is not None and self._hands.held.is_active
            if self._hands is not None and (held or self._late):
                self._late, self._told_at = False, self._clock.now()
                self._pilot.take(self._hands.state(), self._hands.held)
            if not held:
                self._news.clear()

    def _choose(self, reason: str) -> None:
        """Let operate whose turn it is now; `reason` says why it may be another one's than before."""
        turn = self._guests[0] if self._guests and not self._seat.is_held else None
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
        """What is held counts no more: it has to be pressed again."""
        if self._hands is not None:
            self._hands.let_go()
        self._hands, self._late, self._pressed_until = None, False, 0.0


def _goes_down(change: Key | Button | TouchPoint | Pad) -> bool:
    return change.down
