"""Navigation of a robot with a battery: below its limit only the dock is a goal (component 13)."""

from openrois_body.components import navigation
from openrois_body.components.moving import Figure
from openrois_body.messages import Thing
from openrois_body.motion.targets import Position, read_targets

from openrois.adapter import ComponentFailed
from openrois_robots.simulated.battery import Battery
from openrois_robots.simulated.world.plan import Mat

__all__ = ["Navigation"]


class Navigation(navigation.Navigation):
    """Drives to `target_positions` in turn; with a low battery to the dock alone.

    Args:
        figure: the robot.
        battery: the robot's battery.
        mat: where it is charged.
    """

    def __init__(self, figure: Figure, battery: Battery, mat: Mat) -> None:
        super().__init__(figure)
        self._battery = battery
        self._mat = mat

    async def start(self) -> None:
        """Drive to the last target.

        Raises:
            ComponentFailed: the battery is low, and a target is not the dock.
        """
        if refusal := self._battery.refusal:
            targets = read_targets(self.target_positions, self.figure.world) if self.target_positions else ()
            if self._battery.is_empty or any(not self._is_dock(each) for each in targets):
                raise ComponentFailed(refusal)
        await super().start()

    def _is_dock(self, target: Position | Thing) -> bool:
        return target.id == self._mat.name if isinstance(target, Thing) else self._mat.holds(target.x, target.y)
