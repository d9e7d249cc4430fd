"""What the simulated robot does for each command."""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, TypeAlias

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois_robots.kachaka.simulator.errors import ErrorCode
from openrois_robots.kachaka.simulator.house import House, Location, Pose
from openrois_robots.kachaka.simulator.motion import LINEAR, Act, Body, Go, Leg, Turn, Wait, legs_to

__all__ = ["Planned", "Premises", "plan"]

Planned: TypeAlias = list[Leg] | ErrorCode
"""The legs of a command, or why there are none."""

_LETTER: Final = 0.06
"""Seconds that a letter takes to be spoken."""
_DOCKING: Final = 1.0
"""Seconds that docking takes."""
_BEFORE: Final = 1.0
"""Metres from a shelf within which the robot finds it before itself."""


@dataclass(slots=True)
class Premises:
    """The robot in its house, with what it carries.

    Attributes:
        house: where.
        body: what moves.
        changed: called with the name of a topic that has changed.
        shelf_poses: where each shelf stands, by its id.
        carried: id of the shelf on the robot; empty: none.
        is_docked: whether it is at its charger.
    """

    house: House
    body: Body
    changed: Callable[[str], None]
    shelf_poses: dict[str, Pose] = field(init=False)
    carried: str = ""
    is_docked: bool = True

    def __post_init__(self) -> None:
        self.shelf_poses = {each.id: self.pose_of(each.home) or self.body.pose for each in self.house.shelves}

    def pose_of(self, location_id: str) -> Pose | None:
        """Return the pose of a location; None where there is none of this id."""
        return next((each.pose for each in self.house.locations if each.id == location_id), None)

    def home_of(self, shelf_id: str) -> Location | None:
        """Return the home of a shelf; None where there is none of this id."""
        home = next((each.home for each in self.house.shelves if each.id == shelf_id), "")
        return next((each for each in self.house.locations if each.id == home), None)

    def load(self, shelf_id: str) -> None:
        """Take a shelf."""
        self.carried = shelf_id
        self.changed("moving_shelf")

    def unload(self) -> None:
        """Set the shelf down here."""
        self.shelf_poses[self.carried] = self.body.pose
        self.carried = ""
        self.changed("moving_shelf")
        self.changed("shelves")

    def dock(self) -> None:
        """Be charged from now on."""
        self.is_docked = True


def plan(premises: Premises, command: pb2.Command) -> Planned:
    """Return what the robot does for a command."""
    kind = command.WhichOneof("command") or ""
    planning = _PLANS.get(kind)
    return ErrorCode.UNSUPPORTED if planning is None else planning(premises, getattr(command, kind))


def _go(premises: Premises, pose: Pose | None) -> Planned:
    if pose is None:
        return ErrorCode.UNKNOWN_TARGET
    legs = legs_to(premises.house, premises.body.pose, pose)
    return ErrorCode.NO_WAY if legs is None else legs


def _go_home(premises: Premises) -> Planned:
    legs = _go(premises, premises.house.locations[0].pose)
    return legs if isinstance(legs, ErrorCode) else [*legs, Wait(_DOCKING), Act(premises.dock)]


def _carry(premises: Premises, shelf_id: str, goal: Pose | None) -> Planned:
    here = premises.shelf_poses.get(shelf_id)
    if here is None or goal is None:
        return ErrorCode.UNKNOWN_TARGET
    there, onward = _go(premises, here), legs_to(premises.house, here, goal)
    if isinstance(there, ErrorCode) or onward is None:
        return ErrorCode.NO_WAY
    loading: list[Leg] = [Wait(_DOCKING), Act(lambda: premises.load(shelf_id))]
    return [*there, *loading, *onward, Wait(_DOCKING), Act(premises.unload)]


def _return_shelf(premises: Premises, command: pb2.ReturnShelfCommand) -> Planned:
    shelf_id = command.target_shelf_id or premises.carried
    home = premises.home_of(shelf_id)
    return ErrorCode.NO_SHELF if home is None else _carry(premises, shelf_id, home.pose)


def _dock_shelf(premises: Premises, _command: pb2.DockShelfCommand) -> Planned:
    here = premises.body.pose
    for shelf_id, pose in premises.shelf_poses.items():
        if max(abs(pose.x - here.x), abs(pose.y - here.y)) < _BEFORE:
            return [Wait(_DOCKING), Act(lambda chosen=shelf_id: premises.load(chosen))]  # type: ignore[misc]
    return ErrorCode.NO_SHELF


def _undock_shelf(premises: Premises, _command: pb2.UndockShelfCommand) -> Planned:
    return [Wait(_DOCKING), Act(premises.unload)] if premises.carried else ErrorCode.NO_SHELF


_PLANS: Final = MappingProxyType[str, Callable[..., Planned]](
    {
        "move_to_location_command": lambda at, command: _go(at, at.pose_of(command.target_location_id)),
        "move_to_pose_command": lambda at, command: _go(at, Pose(command.x, command.y, command.yaw)),
        "return_home_command": lambda at, _command: _go_home(at),
        "move_forward_command": lambda _at, command: [Go(command.distance_meter, min(LINEAR, command.speed or LINEAR))],
        "rotate_in_place_command": lambda _at, command: [Turn(command.angle_radian)],
        "speak_command": lambda _at, command: [Wait(len(command.text) * _LETTER)],
        "lock_command": lambda _at, command: [Wait(command.duration_sec)],
        "localize_command": lambda _at, _command: [Wait(_DOCKING)],
        "move_shelf_command": lambda at, command: _carry(
            at, command.target_shelf_id, at.pose_of(command.destination_location_id)
        ),
        "return_shelf_command": _return_shelf,
        "dock_shelf_command": _dock_shelf,
        "undock_shelf_command": _undock_shelf,
    }
)
