"""Map: the robot's map as a picture, and the locations on it. A component of OpenRoIS."""

import asyncio
import base64
from typing import Final

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import Component, ComponentStatus, Payload, query
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.plan import scaled
from openrois_robots.kachaka.robot import FRAME, Kachaka

__all__ = ["Map", "fetch_map"]

_DEADLINE: Final = 20.0
"""Seconds that the robot has to send its map, of some megabytes over a slow network."""


class MapResult(Payload):
    """The map: a picture (PNG as base64), and how its pixels are metres of a frame of coordinates.

    The picture is smaller than the robot's where that is large; `resolution` is metres of one of its pixels. `origin`
    is the pose `x,y,th` of its corner at the bottom on the left.
    """

    name: str
    frame: str
    resolution: float
    width: int
    height: int
    origin: str
    png: str


class LocationsResult(Payload):
    """The locations as parallel lists: names, and poses `x,y,th` in the frame of the map. `home` is the charger."""

    name: tuple[str, ...]
    position_data: tuple[str, ...]
    charger: str


class Map(Component, authority="OpenRoIS", function="sensing"):
    """Has the robot's map.

    Args:
        robot: the robot.
        api: of it.
    """

    def __init__(self, robot: Kachaka, api: KachakaApi) -> None:
        super().__init__()
        self._robot = robot
        self._api = api

    def condition(self) -> ComponentStatus:
        """Return the status of the link to the robot."""
        return self._robot.link.status

    def problem(self) -> str:
        """Return why the robot is not linked."""
        return self._robot.link.problem

    @query
    async def map(self) -> MapResult:
        """Return the map that the robot has now."""
        found = await self._robot.link.during(fetch_map(self._api))
        picture = await asyncio.to_thread(scaled, found.data, found.resolution)
        origin = found.origin
        return MapResult(
            name=found.name,
            frame=FRAME,
            resolution=picture.resolution,
            width=picture.width,
            height=picture.height,
            origin=f"{origin.x:.3f},{origin.y:.3f},{origin.theta:.4f}",
            png=base64.b64encode(picture.png).decode(),
        )

    @query
    async def locations(self) -> LocationsResult:
        """Return the locations that the robot knows."""
        locations = self._robot.layout.locations
        return LocationsResult(
            name=tuple(each.name for each in locations),
            position_data=tuple(f"{each.x:.3f},{each.y:.3f},{each.th:.4f}" for each in locations),
            charger=next((each.name for each in locations if each.is_charger), ""),
        )


async def fetch_map(api: KachakaApi) -> pb2.Map:
    """Return the robot's map, of many megabytes if need be.

    Raises:
        RoISError: the call failed, as `KachakaApi.call` says.
    """
    response: pb2.GetPngMapResponse = await api.call("GetPngMap", deadline=_DEADLINE)
    return response.map
