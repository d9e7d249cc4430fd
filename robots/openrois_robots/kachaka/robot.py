"""What the adapter knows of its robot: pose, battery, errors, locations and shelves, told with each sign of life."""

import asyncio
from collections.abc import Awaitable, Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from math import isfinite
from typing import Any, Final, TypeVar

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.messages import Place
from openrois_body.motion.world import World
from openrois_streaming.clock import MediaClock

from openrois.adapter import ComponentStatus, RoISError
from openrois.aio.listeners import Listeners
from openrois_robots.adapter.battery import BatteryLimit, ReportedBattery
from openrois_robots.adapter.link import RobotLink
from openrois_robots.components.system_information import Pose
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.error_texts import ErrorTexts
from openrois_robots.kachaka.layout import Layout, Location, Shelf, is_place

__all__ = ["FRAME", "Kachaka"]

FRAME: Final = "map"
"""Frame of the robot's poses, as it calls it."""

_LAYOUT: Final = 5.0
"""Seconds between two requests for locations and shelves."""


_T = TypeVar("_T", Location, Shelf)


@dataclass(frozen=True, slots=True)
class _Beat:
    """The answers of one sign of life."""

    pose: pb2.Pose
    battery: pb2.GetBatteryInfoResponse
    errors: tuple[int, ...]
    is_ready: bool


class Kachaka:
    """The state of one robot. Its link asks for it.

    Args:
        api: of the robot.
        engine_id: leads the refs of its surroundings.
        limit: of its battery.
        clock: the media clock.

    Attributes:
        link: to the robot; it has to run.
        texts: of its errors.
        battery: as it was told last.
        battery_changed: called when its charge or charging has changed.
        layout: locations and shelves.
        layout_changed: called when these are others.
        world: the robot's surroundings, for a map.
    """

    def __init__(self, api: KachakaApi, engine_id: str, limit: BatteryLimit, clock: MediaClock) -> None:
        self.link = RobotLink(f"the Kachaka at {api.address.text}", self._probe, clock)
        self.texts = ErrorTexts(api)
        self.battery = ReportedBattery(limit)
        self.battery_changed: Listeners[ReportedBattery] = Listeners()
        self.layout = Layout((), (), "")
        self.layout_changed: Listeners[Layout] = Listeners()
        self.world = World(engine_id)
        self._api = api
        self._clock = clock
        self._pose: Pose | None = None
        self._errors: tuple[int, ...] = ()
        self._is_ready = True
        self._layout_due = 0.0
        self.link.changed.add(self._on_link_changed)

    @property
    def pose(self) -> Pose | None:
        """Where the robot was when it said so last; None while it is lost, or tells no place."""
        return self._pose if self.link.is_up else None

    def status(self) -> ComponentStatus:
        """Return the status of what the robot does: ERROR while it is lost, or not ready."""
        if not self.link.is_up:
            return self.link.status
        return ComponentStatus.READY if self._is_ready else ComponentStatus.ERROR

    def problem(self) -> str:
        """Return why the robot does not work, or which errors it tells of; empty where there are none."""
        if not self.link.is_up:
            return self.link.problem
        errors = "; ".join(map(self.texts.sentence, self._errors))
        if self._is_ready:
            return f"the robot tells of {errors}" if errors else ""
        return f"the robot is not ready: {errors}" if errors else "the robot says that it is not ready"

    async def _probe(self) -> None:
        """Ask for a sign of life, and note what it tells.

        Raises:
            RoISError: a call failed, as `KachakaApi.call` says.
        """
        pose, battery, errors, ready = await _all_of(
            self._api.call("GetRobotPose"),
            self._api.call("GetBatteryInfo"),
            self._api.call("GetError"),
            self._api.call("IsReady", pb2.EmptyRequest()),
        )
        self._note(_Beat(pose.pose, battery, tuple(errors.error_codes), ready.ready))
        if not self.texts.is_known:
            await self._load_texts()
        if self._clock.now() >= self._layout_due:
            await self.refresh_layout()

    async def refresh_layout(self) -> None:
        """Ask for locations and shelves.

        Raises:
            RoISError: a call failed, as `KachakaApi.call` says.
        """
        locations, shelves = await _all_of(self._api.call("GetLocations"), self._api.call("GetShelves"))
        self._layout_due = self._clock.now() + _LAYOUT
        layout = Layout(_locations(locations.locations), _shelves(shelves.shelves), str(locations.default_location_id))
        if layout != self.layout:
            self.layout = layout
            self.layout_changed.notify_all(layout)

    async def _load_texts(self) -> None:
        try:
            await self.texts.load()
        except RoISError:
            # Errors are numbers then; it is tried again with the next sign of life.
            return

    def _note(self, beat: _Beat) -> None:
        at = datetime.fromtimestamp(self._clock.wall(), UTC)
        pose = beat.pose
        self._pose = Pose(pose.x, pose.y, pose.theta, FRAME, at) if _is_there(pose) else None
        if self._pose is not None:
            self.world.handle_event(Place(pose.x, pose.y, pose.theta))
        self._errors, self._is_ready = beat.errors, beat.is_ready
        percent = _percent(beat.battery.remaining_percentage)
        charges = beat.battery.power_supply_status == pb2.POWER_SUPPLY_STATUS_CHARGING
        if (percent, charges) != (self.battery.percent, self.battery.is_charging):
            self.battery.percent, self.battery.is_charging = percent, charges
            self.battery_changed.notify_all(self.battery)

    def _on_link_changed(self) -> None:
        if self.link.is_up:
            self._layout_due = 0.0


async def _all_of(*calls: Awaitable[Any]) -> list[Any]:
    """Return the responses of calls that are made at once; the error of the first one, in their order, that failed."""
    answers = await asyncio.gather(*calls, return_exceptions=True)
    for each in answers:
        if isinstance(each, BaseException):
            raise each
    return answers


def _is_there(pose: pb2.Pose) -> bool:
    return is_place(pose.x, pose.y, pose.theta)


def _percent(charge: float) -> int | None:
    """Return a charge in per cent; None where it is no number."""
    return round(max(0.0, min(100.0, charge))) if isfinite(charge) else None


def _locations(locations: Iterable[pb2.Location]) -> tuple[Location, ...]:
    found = (
        Location(each.id, each.name, each.pose.x, each.pose.y, each.pose.theta, each.type == pb2.LOCATION_TYPE_CHARGER)
        for each in locations
        if _is_there(each.pose)
    )
    return _of_ids(found)


def _shelves(shelves: Iterable[pb2.Shelf]) -> tuple[Shelf, ...]:
    found = (
        Shelf(each.id, each.name, each.pose.x, each.pose.y, each.pose.theta, each.home_location_id)
        for each in shelves
        if _is_there(each.pose)
    )
    return _of_ids(found)


def _of_ids(things: Iterable[_T]) -> tuple[_T, ...]:
    """Return things that have an id, and the first one of each, as commands name them by it."""
    found: dict[str, _T] = {}
    for each in things:
        if each.id:
            found.setdefault(each.id, each)
    return tuple(found.values())
