"""Navigation: the robot drives to locations by name, to poses, and home (component 13)."""

import asyncio
from math import atan2
from typing import Annotated, Any, Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from pydantic import Field

from openrois.adapter import BadParameter, TimedOut, components, parameter
from openrois.errors import Aborted
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.layout import Target
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Navigation"]

_MOST_TARGETS: Final = 100
_MILLISECOND: Final = 0.001


class Navigation(Acting, components.Navigation, omit=("routing_policy",)):
    """Drives to `target_positions` in turn: `x,y` or `x,y,th`, the name or id of a location, or `home`.

    With a battery below its limit only the charger is a goal. The robot finds its way, and chooses its speed.

    Args:
        robot: the robot.
        commands: at it.
    """

    time_limit: Annotated[int, Field(ge=0)] = parameter(0)

    def __init__(self, robot: Kachaka, commands: Commands) -> None:
        super().__init__(robot, commands)
        self._going = asyncio.Event()
        self._going.set()

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse targets that are neither positions nor known to the robot, once it has told what it knows."""
        targets = changes.get("target_positions")
        if targets is not None and self.robot.layout.locations:
            self._read(targets)
        return changes

    async def start(self) -> None:
        """Drive to the last target.

        Raises:
            BadParameter: there is no target, or none of this name.
            ComponentFailed: the battery is low and a target is not the charger, or the robot does not get there.
            TimedOut: it took longer than `time_limit`.
        """
        if not self.target_positions:
            raise BadParameter("target_positions is not set; set it before start")
        await self.robot.link.during(self.robot.refresh_layout())
        targets = self._read(self.target_positions)
        if any(not target.is_charger for target in targets):
            self.require_charge()
        self._going.set()
        try:
            async with asyncio.timeout(self.time_limit * _MILLISECOND or None):
                for index, target in enumerate(targets):
                    await self._visit(target)
                    self.reached_target(target.text, index == len(targets) - 1)
        except TimeoutError:
            raise TimedOut(f"{self.name} took longer than {self.time_limit} ms") from None

    async def suspend(self) -> None:
        """Let the robot stand until `resume`; the time limit goes on."""
        self._going.clear()
        await self.commands.cancel(self.name, f"{self.name} was suspended")

    async def resume(self) -> None:
        """Go on to the target that was not reached."""
        self._going.set()

    async def _visit(self, target: Target) -> None:
        while True:
            await self._going.wait()
            try:
                await self.perform(self._command(target), f"go to {target.text!r}")
            except Aborted:
                if self._going.is_set():
                    raise
            else:
                return

    def _command(self, target: Target) -> pb2.Command:
        if target.is_charger:
            return pb2.Command(return_home_command=pb2.ReturnHomeCommand())
        if target.location is not None:
            return pb2.Command(
                move_to_location_command=pb2.MoveToLocationCommand(target_location_id=target.location.id)
            )
        th = target.th
        if th is None:
            here = self.robot.pose
            th = 0.0 if here is None else atan2(target.y - here.y, target.x - here.x)
        return pb2.Command(move_to_pose_command=pb2.MoveToPoseCommand(x=target.x, y=target.y, yaw=th))

    def _read(self, texts: tuple[str, ...]) -> list[Target]:
        if not 1 <= len(texts) <= _MOST_TARGETS:
            raise BadParameter(f"target_positions: expected 1 to {_MOST_TARGETS} positions")
        return [self.robot.layout.target(text) for text in texts]
