"""Reaction: key-framed gestures of head and antennas, waking up and going to sleep (component 12)."""

from openrois_body.components import reaction

from openrois.adapter import ComponentStatus
from openrois_robots.reachy.components.acting import Acting
from openrois_robots.reachy.daemon.rest import Daemon
from openrois_robots.reachy.motion import Motion
from openrois_robots.reachy.postures.gestures import GESTURES, SLEEPING, WAKING
from openrois_robots.reachy.robot import ENABLED, Reachy

__all__ = ["Reaction"]

_DISABLED = "disabled"


class Reaction(Acting, reaction.Reaction):
    """Plays a gesture; without a network too: none is downloaded. While the robot sleeps, `wake_up` alone.

    Args:
        robot: the robot.
        motion: of the robot.
    """

    dead_man = 0.5

    def __init__(self, robot: Reachy, motion: Motion) -> None:
        super().__init__(self, lambda: tuple(GESTURES), robot.motion_status)
        self.robot = robot
        self.motion = motion

    def condition(self) -> ComponentStatus:
        """Return the status of the link to the robot: one that sleeps can be woken."""
        return self.robot.link.status

    def problem(self) -> str:
        """Return why the robot is not linked."""
        return self.robot.link.problem

    async def react(self, name: str) -> None:
        """Play a gesture to its end; raises as `Motion.perform`."""
        if name == WAKING and self.robot.motor_problem():
            await self._switch_motors(ENABLED)
        await self.motion.perform(self.name, _DOING.get(name, f"play {name}"), GESTURES[name])
        if name == SLEEPING:
            await self._switch_motors(_DISABLED)

    async def _switch_motors(self, mode: str) -> None:
        daemon: Daemon = self.robot.daemon

        async def switch() -> None:
            await daemon.post(f"/api/motors/set_mode/{mode}")
            await self.robot.refresh()

        await self.robot.link.during(switch())


_DOING = {WAKING: "wake up", SLEEPING: "go to sleep"}
