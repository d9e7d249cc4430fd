"""Who operates the avatar by hand: the application that holds the component, while it is started, and nobody else."""

import asyncio
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.input.holding import Holding
from openrois_streaming.input.reader import MALFORMED_LIMIT, InputReader, Label
from openrois_streaming.peer.input_channels import InputSink

from openrois.aio.listeners import Listeners
from openrois.contract import Client
from openrois.errors import OutOfResources
from openrois.types.streams import HolderNotification
from openrois_avatar.teleoperation.pilot import Pilot

__all__ = ["Seat", "SeatFigures"]

_TELL_INTERVAL: Final = 1.0
"""Seconds between two words to an application that its input is not taken."""


@dataclass(slots=True)
class SeatFigures:
    """What became of the input messages of all applications."""

    taken: int = 0
    """By whoever operates."""
    refused: int = 0
    """Of applications that do not operate."""
    malformed: int = 0
    """That cannot be read."""
    dropped: int = 0
    """That came too late, or too many."""


class Seat:
    """The place of who operates one avatar.

    Args:
        component_ref: of the component that has to be bound.
        clock: for the pace of messages.
    """

    def __init__(self, component_ref: str, clock: MediaClock) -> None:
        self.component_ref = component_ref
        self.figures = SeatFigures()
        self.held = Listeners[bool]()
        """Hear whether an application holds the component now, when that changes."""
        self._clock = clock
        self._holder: Client | None = None
        self._epoch = 0
        self._pilot: Pilot | None = None
        self._vacated: asyncio.Future[str] | None = None
        self._tell: Callable[[str], None] = _nobody_hears

    @property
    def is_held(self) -> bool:
        """Whether an application holds the component, operating or not."""
        return self._holder is not None

    def take_holder(self, told: HolderNotification, client: Client) -> None:
        """Take what the gateway says about who holds a component."""
        if told.component_ref != self.component_ref:
            return
        if told.holds and (self._holder is None or told.epoch >= self._epoch):
            if self._holder is not client:
                self._vacate("another application has bound the component")
            self._holder, self._epoch = client, told.epoch
            self.held.tell(True)
        elif not told.holds and self._holder is client:
            self._vacate("the component was released")

    def forget(self, client: Client) -> None:
        """An application is gone."""
        if self._holder is client:
            self._vacate("the application that operated is gone")

    def hands(
        self,
        client: Client,
        tell: Callable[[str], None],
        round_trip: Callable[[], float | None] = lambda: None,
    ) -> InputSink:
        """Return what hears the input of an application.

        Args:
            client: the application.
            tell: sends it a message at its own channel.
            round_trip: returns the seconds that a packet takes to it and back; None where that is not known.
        """
        return _Hands(self, client, tell, round_trip, self._clock)

    @contextmanager
    def operated(self, pilot: Pilot) -> Iterator["asyncio.Future[str]"]:
        """Let whoever holds the component operate for as long as the context lasts.

        Yields:
            Done with a reason when nobody holds it any more.

        Raises:
            OutOfResources: nobody holds it, as far as this adapter was told.
        """
        if self._holder is None:
            raise OutOfResources(
                f"no application has bound {self.component_ref}, or the gateway does not tell which one"
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
                self._tell = _nobody_hears

    def pilot_for(self, client: Client) -> Pilot | None:
        """Return who operates for an application; None where that one does not."""
        return self._pilot if self._holder is client else None

    def tell_operator(self, event: str, reason: str) -> None:
        """Tell the application that operates something, at its own channel."""
        self._tell(json.dumps({"event": event, "reason": reason}))

    def heard_from(self, tell: Callable[[str], None]) -> None:
        """Note how the application that operates can be told something."""
        self._tell = tell

    def _vacate(self, reason: str) -> None:
        self._holder = None
        pilot, self._pilot = self._pilot, None
        if pilot is not None:
            pilot.lose(reason)
            self._tell = _nobody_hears
        if self._vacated is not None and not self._vacated.done():
            self._vacated.set_result(reason)
        self.held.tell(False)


class _Hands:
    """The input of one application; an `InputSink`."""

    def __init__(
        self,
        seat: Seat,
        client: Client,
        tell: Callable[[str], None],
        round_trip: Callable[[], float | None],
        clock: MediaClock,
    ) -> None:
        self._seat = seat
        self._round_trip = round_trip
        self._client = client
        self._tell = tell
        self._clock = clock
        self._reader = InputReader(clock.now)
        self._holding = Holding()
        self._told_at: float | None = None

    def input_came(self, label: Label, data: str | bytes) -> None:
        figures = self._seat.figures
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
        pilot = self._seat.pilot_for(self._client)
        if pilot is not None and pilot.has_let_go:
            self._holding.clear()
        if not self._holding.take(message):
            figures.dropped += 1
            return
        if pilot is None:
            figures.refused += 1
            self._refuse(f"{self._seat.component_ref} has to be bound and started first")
        else:
            figures.taken += 1
            self._seat.heard_from(self._tell)
            pilot.take(message, self._holding.held, self._round_trip())

    def input_lost(self, reason: str) -> None:
        self._holding.clear()
        pilot = self._seat.pilot_for(self._client)
        if pilot is not None:
            pilot.lose(reason)

    def _refuse(self, reason: str) -> None:
        now = self._clock.now()
        if self._told_at is None or now - self._told_at >= _TELL_INTERVAL:
            self._told_at = now
            self._tell(json.dumps({"event": "refused", "reason": reason}))


def _nobody_hears(_text: str) -> None:
    """Stand in until the application that operates has sent something."""
