"""Operation of a body by hand, by the one application that holds the started component."""

import asyncio
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.input.held_input import HeldInput
from openrois_streaming.input.reader import MALFORMED_LIMIT, InputReader, Label
from openrois_streaming.peer.input_channels import InputSink

from openrois.aio.listeners import Listeners
from openrois.contract import Client
from openrois.errors import OutOfResources
from openrois.types.streams import HolderNotification
from openrois_body.holder import ComponentHolder
from openrois_body.teleoperation.pilot import Pilot

__all__ = ["OperatorControl", "OperatorFigures"]

_REFUSAL_INTERVAL: Final = 1.0
"""Seconds between two notices to an application that its input is refused."""


@dataclass(slots=True)
class OperatorFigures:
    """Counts of the input messages of all applications, by outcome."""

    taken: int = 0
    """Messages of the application that operates."""
    refused: int = 0
    """Messages of applications that do not operate."""
    malformed: int = 0
    """Messages that cannot be read."""
    dropped: int = 0
    """Messages that came too late, or were too many."""


class OperatorControl:
    """Decides which application operates one body: the one that holds its component.

    Args:
        component_ref: of the component that has to be bound.
        clock: for the pace of messages.
        gaze_ref: of the component that turns the body's eyes; empty where there is none.
    """

    def __init__(self, component_ref: str, clock: MediaClock, gaze_ref: str = "") -> None:
        self._held = ComponentHolder(component_ref)
        self._gaze = ComponentHolder(gaze_ref)
        self.figures = OperatorFigures()
        self.held_changed = Listeners[bool]()
        """Called with whether an application holds the component now, when that changes."""
        self._clock = clock
        self._pilot: Pilot | None = None
        self._vacated: asyncio.Future[str] | None = None
        self._reply: Callable[[str], None] = _discard

    @property
    def component_ref(self) -> str:
        """The component that has to be bound."""
        return self._held.component_ref

    @property
    def is_held(self) -> bool:
        """Whether an application holds the component, operating or not."""
        return self._held.client is not None

    @property
    def may_turn_eyes(self) -> bool:
        """Whether input turns the eyes: not where an application that does not operate holds the body's gaze."""
        return self._gaze.client is None or self._gaze.client is self._held.client

    def apply_holder(self, notification: HolderNotification, client: Client) -> None:
        """Follow the gateway's notification of the application that holds a component."""
        self._gaze.apply(notification, client)
        before = self._held.client
        lost = self._held.apply(notification, client)
        if lost:
            self._vacate(lost)
        if self._held.client is not before:
            self.held_changed.notify_all(self.is_held)

    def forget_client(self, client: Client) -> None:
        """End the operation by an application that has disconnected."""
        self._gaze.forget_client(client)
        if self._held.forget_client(client):
            self._vacate("the application that operated is gone")
            self.held_changed.notify_all(False)

    def input_sink(
        self,
        client: Client,
        reply: Callable[[str], None],
        round_trip: Callable[[], float | None] = lambda: None,
    ) -> InputSink:
        """Return a sink for the input of an application.

        Args:
            client: the application.
            reply: sends it a message at its own channel.
            round_trip: returns the seconds that a packet takes to it and back; None where that is not known.
        """
        return _ClientInput(self, client, reply, round_trip, self._clock)

    @contextmanager
    def operated(self, pilot: Pilot) -> Iterator["asyncio.Future[str]"]:
        """Let the application that holds the component operate for as long as the context lasts.

        Yields:
            Done with a reason when no application holds it any more.

        Raises:
            OutOfResources: no application holds it, as far as this adapter was notified.
        """
        if not self.is_held:
            raise OutOfResources(
                f"no application has bound {self.component_ref}, or the gateway does not notify this adapter of it"
            )
        vacated: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self._pilot, self._vacated = pilot, vacated
        try:
            yield vacated
        finally:
            pilot.lose("teleoperation was stopped")
            vacated.cancel()
            if self._pilot is pilot:
                self._pilot = self._vacated = None
                self._reply = _discard

    def pilot_for(self, client: Client) -> Pilot | None:
        """Return the pilot of the application that operates; None for another one."""
        return self._pilot if self._held.client is client else None

    def notify_operator(self, event: str, reason: str) -> None:
        """Notify the application that operates, over its own data channel."""
        self._reply(json.dumps({"event": event, "reason": reason}))

    def set_reply(self, reply: Callable[[str], None]) -> None:
        """Set the function that sends the application that operates a message."""
        self._reply = reply

    def _vacate(self, reason: str) -> None:
        pilot, self._pilot = self._pilot, None
        if pilot is not None:
            pilot.lose(reason)
            self._reply = _discard
        if self._vacated is not None and not self._vacated.done():
            self._vacated.set_result(reason)


class _ClientInput:
    """The input of one application; an `InputSink`."""

    def __init__(
        self,
        control: OperatorControl,
        client: Client,
        reply: Callable[[str], None],
        round_trip: Callable[[], float | None],
        clock: MediaClock,
    ) -> None:
        self._control = control
        self._round_trip = round_trip
        self._client = client
        self._reply = reply
        self._clock = clock
        self._reader = InputReader(clock.now)
        self._held = HeldInput()
        self._refused_at: float | None = None

    def input_came(self, label: Label, data: str | bytes) -> None:
        figures = self._control.figures
        malformed = self._reader.figures.malformed
        message = self._reader.read(label, data)
        if message is None:
            if self._reader.figures.malformed > malformed:
                figures.malformed += 1
            else:
                figures.dropped += 1
            if self._reader.is_cut:
                self._refuse(f"{MALFORMED_LIMIT} messages could not be read, the last one: {self._reader.last_fault}")
            return
        pilot = self._control.pilot_for(self._client)
        if pilot is not None and pilot.has_let_go:
            self._held.clear()
        if not self._held.apply(message):
            figures.dropped += 1
            return
        if pilot is None:
            figures.refused += 1
            self._refuse(f"{self._control.component_ref} has to be bound and started first")
        else:
            figures.taken += 1
            self._control.set_reply(self._reply)
            pilot.handle_input(message, self._held.held, self._round_trip())

    def input_lost(self, reason: str) -> None:
        self._held.clear()
        pilot = self._control.pilot_for(self._client)
        if pilot is not None:
            pilot.lose(reason)

    def _refuse(self, reason: str) -> None:
        now = self._clock.now()
        if self._refused_at is None or now - self._refused_at >= _REFUSAL_INTERVAL:
            self._refused_at = now
            self._reply(json.dumps({"event": "refused", "reason": reason}))


def _discard(_text: str) -> None:
    """Stand in until the application that operates has sent something."""
