"""Teleoperation: the body is operated with keyboard, mouse, touch and gamepad. A component of OpenRoIS."""

from collections.abc import Callable
from typing import Annotated

from openrois_streaming.clock import MediaClock
from pydantic import Field

from openrois.adapter import Component, ComponentStatus, Payload, command, event, parameter, query
from openrois.aio.tasks import TaskScope
from openrois.errors import Aborted
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.pilot import Controls, Pilot
from openrois_body.teleoperation.steering import STANDING, Steering

__all__ = ["Teleoperation"]


class OperationResult(Payload):
    """State of the operation: `active` while something is held or moves; messages are counted since the adapter began.

    `pace` is the share of the full speed that is used: less than 1 where the round trip to the operator is long.
    """

    operated: bool
    active: bool
    ahead: float
    left: float
    turn: float
    pace: float
    stopped_because: str
    taken: int
    refused: int
    malformed: int
    dropped: int


class Teleoperation(Component, authority="OpenRoIS", function="actuation", part="legs"):
    """Lets the application that has bound it drive the body and turn its eyes, over the data channels of its streams.

    Where another application holds the body's gaze, the eyes are that one's.

    Args:
        operator_control: knows which application operates.
        controls: of the figure.
        engine_status: returns the status of the game engine.
        clock: the media clock.
    """

    max_speed: Annotated[float, Field(ge=0.05, le=5)] = parameter(0.8, description="m/s at full deflection")
    max_turn: Annotated[float, Field(ge=0.05, le=10)] = parameter(1.5, description="rad/s at full deflection")
    dead_zone: Annotated[float, Field(ge=0, le=0.9)] = parameter(0.12, description="of a stick's deflection")
    expo: Annotated[float, Field(ge=0, le=1)] = parameter(0.5, description="of a stick: 0 linear, 1 cubic")

    def __init__(
        self,
        operator_control: OperatorControl,
        controls: Controls,
        engine_status: Callable[[], ComponentStatus],
        clock: MediaClock,
    ) -> None:
        super().__init__()
        self.operator_control = operator_control
        self._controls = controls
        self._engine_status = engine_status
        self._clock = clock
        self._pilot: Pilot | None = None
        self._stopped_because = ""

    def pilot(self, stopped: Callable[[str], None]) -> Pilot:
        """Return a pilot with the component's parameters; `stopped` gets the reason when it stops by itself."""
        return Pilot(
            self._controls,
            self._steering,
            self._clock,
            stopped,
            self._tell_paced,
            lambda: self.operator_control.may_turn_eyes,
        )

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    @command
    async def start(self) -> None:
        """Accept the input of the application that has bound the component, until `stop` or its release.

        Raises:
            OutOfResources: no application has bound it.
            Aborted: it was released, or the application is disconnected.
        """
        pilot = self.pilot(self._tell_stopped)
        with self.operator_control.operated(pilot) as vacated:
            self._pilot, self._stopped_because = pilot, ""
            try:
                async with TaskScope() as tasks:
                    tasks.start(pilot.watch())
                    raise Aborted(await vacated)
            finally:
                self._pilot = None

    @command
    async def stop(self) -> None:
        """Accept no more input; the body stands."""

    @query
    async def operation(self) -> OperationResult:
        """Return whether the body is operated, how it moves, and counts of input messages."""
        pilot, figures = self._pilot, self.operator_control.figures
        velocity = pilot.velocity if pilot is not None else STANDING
        return OperationResult(
            operated=pilot is not None,
            active=pilot is not None and pilot.is_active,
            ahead=velocity.ahead,
            left=velocity.left,
            turn=velocity.turn,
            pace=1.0 if pilot is None else pilot.pace,
            stopped_because=self._stopped_because,
            taken=figures.taken,
            refused=figures.refused,
            malformed=figures.malformed,
            dropped=figures.dropped,
        )

    @event
    def stopped(self, reason: str) -> None:
        """The body was stopped, or held keys count no more, although the operator did not release them.

        Args:
            reason: a sentence for a person
        """

    def _steering(self) -> Steering:
        return Steering(self.max_speed, self.max_turn, self.dead_zone, self.expo)

    def _tell_paced(self, sentence: str) -> None:
        self.operator_control.notify_operator("paced", sentence)

    def _tell_stopped(self, reason: str) -> None:
        self._stopped_because = reason
        self.operator_control.notify_operator("stopped", reason)
        self.stopped(reason)
