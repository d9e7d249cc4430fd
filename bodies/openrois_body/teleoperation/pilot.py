"""Operation of the figure by input, with a dead man's switch: without messages the figure stops."""

import asyncio
import logging
from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

from openrois_streaming.clock import MediaClock
from openrois_streaming.input.messages import Held, Message, Release

from openrois.errors import ComponentFailed
from openrois_body.teleoperation.steering import STANDING, Steering, Velocity, pace

__all__ = ["PATIENCE", "Controls", "Pilot"]

SLOW: Final = 0.9
"""Share of the full speed below which the operator is notified that the figure goes slower."""

PATIENCE: Final = 0.4
"""Seconds without a message, while something is held, after which the figure stops. Pages send ten or more a second."""

_REASONS: Final = {
    "blur": "the operator's page lost the focus",
    "hidden": "the operator's page was hidden",
    "bye": "the operator released the controls",
    "lost": "the operator's page was closed",
}

_log = logging.getLogger(__name__)


class Controls(Protocol):
    """The controls of the figure."""

    def drive(self, velocity: Velocity) -> None:
        """Go with this velocity for half a second at most.

        Raises:
            ComponentFailed: the game engine is disconnected, or its figure does not walk.
        """
        ...

    def halt(self, reason: str) -> None:
        """Stand still now."""
        ...

    def turn_eyes(self, x: float, y: float) -> None:
        """Turn the eyes.

        Raises:
            ComponentFailed: the game engine is disconnected.
        """
        ...

    def pass_on(self, message: Mapping[str, Any]) -> None:
        """Send the message to a game engine that takes input; never raises."""
        ...


class Pilot:
    """Operates the figure for one application, from its `start` to its end; `watch` has to run meanwhile.

    Args:
        controls: of the figure.
        steering: returns the present steering parameters.
        clock: for the dead man's switch.
        stopped: called with the reason when the figure stops, or held keys count no more, without a release.
        paced: called with a sentence when the figure begins to go slower, and when it goes at full speed again.
        may_turn_eyes: returns whether input turns the eyes now.
    """

    def __init__(
        self,
        controls: Controls,
        steering: Callable[[], Steering],
        clock: MediaClock,
        stopped: Callable[[str], None],
        paced: Callable[[str], None] = lambda _sentence: None,
        may_turn_eyes: Callable[[], bool] = lambda: True,
    ) -> None:
        self.velocity = STANDING
        self.pace = 1.0
        """The share of the full speed at which the figure goes."""
        self.has_let_go = True
        """Whether keys that are held now count no more at the next message."""
        self._controls = controls
        self._steering = steering
        self._clock = clock
        self._stopped = stopped
        self._paced = paced
        self._may_turn_eyes = may_turn_eyes
        self._is_slow = False
        self._gaze: tuple[float, float] | None = None
        self._fed_at = clock.now()
        self._active = asyncio.Event()
        self._last: tuple[int, float] = (0, 0.0)
        self._refusal = ""

    @property
    def is_active(self) -> bool:
        """Whether something is held, or moves."""
        return self._active.is_set()

    def handle_input(self, message: Message, held: Held, round_trip: float | None = None) -> None:
        """Act on an input message.

        Args:
            message: the newest one.
            held: all keys, buttons and axes that are held with it.
            round_trip: seconds to the operator and back; None where that is not known.
        """
        self._fed_at = self._clock.now()
        self.has_let_go = False
        self._last = message.seq, message.t
        self._controls.pass_on(message.to_json())
        if isinstance(message, Release):
            if self.is_active:
                self._stop(_REASONS[message.why])
            return
        self._follow_path(round_trip)
        steering = self._steering().at(self.pace)
        try:
            self._turn_eyes(steering.gaze(held))
            self._go(steering.velocity(held))
        except ComponentFailed as error:
            self._fail(str(error))
        else:
            self._refusal = ""
            if held.is_active or self.velocity != STANDING:
                self._active.set()
            else:
                self._active.clear()

    def lose(self, reason: str) -> None:
        """Release all that is held, as its messages do not arrive any more."""
        if self.is_active:
            self.has_let_go = True
            seq, t = self._last
            self._controls.pass_on(Release(seq + 1, t, "lost").to_json())
            self._stop(reason)

    async def watch(self) -> None:
        """Stop the figure whenever messages stay away, until cancelled."""
        while True:
            await self._active.wait()
            due = self._fed_at + PATIENCE
            if self._clock.now() < due:
                await self._clock.sleep_until(due)
            else:
                self.lose(f"no input came for {PATIENCE:g} s")

    def _follow_path(self, round_trip: float | None) -> None:
        if round_trip is None:
            # The last known round trip counts on: a slow path is not known to be fast.
            return
        self.pace = pace(round_trip)
        if self.pace == 1.0 and self._is_slow:
            self._is_slow = False
            self._paced("the body goes at full speed again")
        elif self.pace < SLOW and not self._is_slow:
            self._is_slow = True
            self._paced(f"the round trip to the body takes {round_trip:.1f} s: it goes slower")

    def _fail(self, reason: str) -> None:
        """Stop after a failure of the game engine, reported once; each message tries again."""
        self.velocity = STANDING
        self._gaze = None
        self._active.clear()
        if reason != self._refusal:
            self._refusal = reason
            self._stop(reason)

    def _go(self, velocity: Velocity) -> None:
        if velocity != STANDING:
            self.velocity = velocity
            self._controls.drive(velocity)
        elif self.velocity != STANDING:
            self.velocity = STANDING
            self._controls.halt("the operator released the controls")

    def _turn_eyes(self, gaze: tuple[float, float] | None) -> None:
        if not self._may_turn_eyes():
            # They look elsewhere meanwhile: the next gaze that counts turns them, be it the same as before.
            self._gaze = None
        elif gaze is not None and gaze != self._gaze:
            self._gaze = gaze
            self._controls.turn_eyes(*gaze)

    def _stop(self, reason: str) -> None:
        moved, self.velocity = self.velocity != STANDING, STANDING
        self._active.clear()
        if moved:
            self._controls.halt(reason)
        _log.info("the body is not operated: %s", reason)
        self._stopped(reason)
