"""The robot's detection of persons, asked for while a sense is active."""

import asyncio
from math import inf, isfinite
from typing import Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.sensing.activity import Activity
from openrois_body.sensing.changes import Place
from openrois_body.vision.box import place_on_floor
from openrois_body.vision.sighting import Sighting
from openrois_streaming.clock import MediaClock, wall_at

from openrois.adapter import RoISError
from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois_robots.adapter.link import RobotLink
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.polling import Poll
from openrois_robots.kachaka.layout import is_place
from openrois_robots.kachaka.persons import Found, Lens, PersonTracks

__all__ = ["Detection"]

_RETRY: Final = 1.0
"""Seconds after a call that failed."""
_USUAL: Final = Lens.usual(1280, 720)


class Detection:
    """The persons that the robot detects with its front camera; a `SightingSource`. `run` has to run.

    Args:
        api: of the robot.
        link: to it.
        clock: the media clock.

    Attributes:
        seen: called with all persons of each detection, and with none when it ends.
    """

    def __init__(self, api: KachakaApi, link: RobotLink, clock: MediaClock) -> None:
        self.seen: Listeners[Sighting] = Listeners()
        self._api = api
        self._link = link
        self._clock = clock
        self._poll = Poll(api, "GetObjectDetection", clock, 2.0)
        self._wishes: list[Activity] = []
        self._changed = asyncio.Event()
        self._tracks = PersonTracks()
        self._lens: Lens | None = None
        self._camera: Place | None = None
        self._failure = ""

    def problem(self) -> str:
        """Return why persons cannot be detected; empty where they can."""
        return self._link.problem if not self._link.is_up else self._failure

    def locate(self, seen: Place) -> Place | None:
        """Return where on the map something is, by its place in the axes of the camera; None: it is not known.

        The camera is taken to be in the middle of the robot: where it is fixed the robot does not tell.
        """
        return None if self._camera is None else place_on_floor(seen, self._camera)

    def serve(self, activity: Activity) -> None:
        """Detect while `activity` is active."""
        self._wishes.append(activity)
        activity.changed.add(lambda _works: self._changed.set())

    def wall_at(self, moment: float) -> float:
        """Return the time of day, in seconds since the epoch, of a moment of the media clock."""
        return wall_at(self._clock, moment)

    async def run(self) -> None:
        """Detect until cancelled."""
        while True:
            await self._until(wanted=True)
            self._poll.restart()
            async with TaskScope() as tasks:
                tasks.start(self._detect())
                await self._until(wanted=False)
            self._clear()

    async def _until(self, *, wanted: bool) -> None:
        while any(wish.works for wish in self._wishes) != wanted:
            self._changed.clear()
            await self._changed.wait()

    async def _detect(self) -> None:
        while True:
            try:
                if self._lens is None:
                    self._lens = await self._ask_lens()
                response: pb2.GetObjectDetectionResponse = await self._poll.next()
                pose: pb2.GetRobotPoseResponse = await self._api.call("GetRobotPose")
            except RoISError as error:
                self._failure = str(error)
                self._clear()
                await self._clock.sleep_until(self._clock.now() + _RETRY)
                continue
            self._failure = ""
            at = pose.pose
            self._camera = Place(at.x, at.y, at.theta) if is_place(at.x, at.y, at.theta) else None
            now = self._clock.now()
            self.seen.notify_all(Sighting(now, self._tracks.update(_persons(response), self._lens, now)))

    async def _ask_lens(self) -> Lens:
        response: pb2.GetFrontCameraRosCameraInfoResponse = await self._api.call("GetFrontCameraRosCameraInfo")
        info = response.camera_info
        has_matrix = len(info.K) == 9 and 0 < info.K[0] < inf and isfinite(info.K[2]) and info.width and info.height
        return Lens(info.width, info.height, info.K[0], info.K[2]) if has_matrix else _USUAL

    def _clear(self) -> None:
        self._tracks.clear()
        self.seen.notify_all(Sighting(self._clock.now()))


def _persons(response: pb2.GetObjectDetectionResponse) -> list[Found]:
    return [
        Found(each.roi.x_offset, each.roi.y_offset, each.roi.width, each.roi.height, each.score, each.distance_median)
        for each in response.objects
        if each.label == pb2.OBJECT_LABEL_PERSON
    ]
