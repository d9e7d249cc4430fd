"""Shelves: the robot carries shelves between locations. A component of OpenRoIS."""

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import Component, Payload, command, query
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Shelves"]


class ShelvesResult(Payload):
    """The shelves as parallel lists: names, where each was last as `x,y,th` in the frame of the map, and its home."""

    name: tuple[str, ...]
    position_data: tuple[str, ...]
    home: tuple[str, ...]


class Shelves(Acting, Component, authority="OpenRoIS", function="actuation", part="legs"):
    """Lets the robot carry shelves. Shelves and locations are named, or given by the robot's ids.

    Args:
        robot: the robot.
        commands: at it.
        api: of it.
    """

    dead_man = 0.5

    def __init__(self, robot: Kachaka, commands: Commands, api: KachakaApi) -> None:
        super().__init__(robot, commands)
        self._api = api

    @query
    async def shelves(self) -> ShelvesResult:
        """Return the shelves that the robot knows."""
        layout = self.robot.layout
        names = {each.id: each.name for each in layout.locations}
        return ShelvesResult(
            name=tuple(each.name for each in layout.shelves),
            position_data=tuple(f"{each.x:.3f},{each.y:.3f},{each.th:.4f}" for each in layout.shelves),
            home=tuple(names.get(each.home, each.home) for each in layout.shelves),
        )

    @query
    async def carried_shelf(self) -> str:
        """Return the name of the shelf that the robot carries; empty: none."""
        response: pb2.GetMovingShelfIdResponse = await self.robot.link.during(self._api.call("GetMovingShelfId"))
        return self.robot.layout.shelf_name(response.shelf_id) if response.shelf_id else ""

    @command
    async def move_shelf(self, shelf: str, location: str) -> None:
        """Fetch a shelf, carry it to a location, and set it down there.

        Args:
            shelf: its name
            location: its name
        """
        self.require_charge()
        layout = self.robot.layout
        chosen, goal = layout.shelf(shelf), layout.location(location)
        moving = pb2.MoveShelfCommand(target_shelf_id=chosen.id, destination_location_id=goal.id)
        await self.perform(pb2.Command(move_shelf_command=moving), f"carry {shelf!r} to {location!r}")

    @command
    async def return_shelf(self, shelf: str = "") -> None:
        """Carry a shelf to its home.

        Args:
            shelf: its name; the shelf that is carried unless given
        """
        self.require_charge()
        chosen = self.robot.layout.shelf(shelf).id if shelf else ""
        command = pb2.Command(return_shelf_command=pb2.ReturnShelfCommand(target_shelf_id=chosen))
        await self.perform(command, f"carry {shelf!r} home" if shelf else "carry its shelf home")

    @command
    async def dock_shelf(self) -> None:
        """Take the shelf that stands before the robot."""
        self.require_charge()
        await self.perform(pb2.Command(dock_shelf_command=pb2.DockShelfCommand()), "take the shelf before it")

    @command
    async def undock_shelf(self) -> None:
        """Set down the shelf that is carried, here."""
        await self.perform(pb2.Command(undock_shelf_command=pb2.UndockShelfCommand()), "set its shelf down")

    @command
    async def stop(self) -> None:
        """Stand; what runs ends with ABORT. A shelf that is carried stays on the robot."""
        await super().stop()
