"""The robot's floor and locations as the surroundings of a body: for maps that applications draw."""

import asyncio
import logging
from typing import Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.messages import Thing, Things
from openrois_streaming.clock import MediaClock

from openrois.adapter import RoISError
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.components.map import fetch_map
from openrois_robots.kachaka.layout import Layout, Location, Shelf
from openrois_robots.kachaka.plan import floor_of
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Ground"]

_log = logging.getLogger(__name__)

_PERIOD: Final = 10.0
"""Seconds between two questions which map the robot uses."""
_MAX_NAME: Final = 200
_MAX_THINGS: Final = 100


class Ground:
    """Keeps the surroundings up to date; `run` has to run.

    Args:
        robot: the robot.
        api: of it.
        clock: the media clock.
    """

    def __init__(self, robot: Kachaka, api: KachakaApi, clock: MediaClock) -> None:
        self._robot = robot
        self._api = api
        self._clock = clock
        self._map_id: str | None = None
        robot.layout_changed.add(self._on_layout_changed)

    async def run(self) -> None:
        """Ask for the map whenever the robot uses another one, until cancelled."""
        while True:
            if self._robot.link.is_up:
                try:
                    await self._refresh()
                except RoISError as error:
                    _log.info("the robot's map: %s", error)
            await self._clock.sleep_until(self._clock.now() + (_PERIOD if self._map_id is not None else 1.0))

    async def _refresh(self) -> None:
        current: pb2.GetCurrentMapIdResponse = await self._api.call("GetCurrentMapId")
        if current.id == self._map_id:
            return
        found = await fetch_map(self._api)
        corner = found.origin.x, found.origin.y
        floor = await asyncio.to_thread(floor_of, found.data, found.resolution, corner)
        self._map_id = current.id
        if floor is not None:
            self._robot.world.handle_event(floor)

    def _on_layout_changed(self, layout: Layout) -> None:
        things = [_thing("location", each) for each in layout.locations]
        things += [_thing("shelf", each) for each in layout.shelves]
        self._robot.world.handle_event(Things(tuple(things[:_MAX_THINGS])))


def _thing(kind: str, place: Location | Shelf) -> Thing:
    name = place.name[:_MAX_NAME]
    return Thing(f"{kind}/{place.id}"[:_MAX_NAME], "object", place.x, place.y, place.th, name)
