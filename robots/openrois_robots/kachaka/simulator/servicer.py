"""The vendor's gRPC service over the simulated robot: requests with cursors wait for changes."""

import asyncio
import socket
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from functools import partial
from typing import Any, Final, TypeAlias

import cv2
import grpc
import numpy as np
from kachaka_api.generated import kachaka_api_pb2 as pb2
from kachaka_api.generated.kachaka_api_pb2_grpc import KachakaApiServicer, add_KachakaApiServicer_to_server
from numpy.typing import NDArray

from openrois_robots.kachaka.simulator.errors import ErrorCode, error_code_json
from openrois_robots.kachaka.simulator.house import Pose
from openrois_robots.kachaka.simulator.robot import SimulatedKachaka
from openrois_robots.kachaka.simulator.view import FOCAL, SIZE, draw, encode, persons_in_view

__all__ = ["FRAME_RATE", "Picture", "SimulatorServicer", "serve_simulator"]

FRAME_RATE: Final = 30.0
"""Pictures a second of each camera."""
_TICK: Final = 0.02
"""Seconds between two steps of the simulation."""
_LARGEST: Final = 64 << 20
"""Bytes of a message."""
_GRACE: Final = 0.1
"""Seconds that requests have for their answers when the server ends."""
_SOUNDS: Final = (("chime", "Chime"), ("thanks", "Thank you"))

Picture: TypeAlias = Callable[[Pose, int, str], NDArray[np.uint8]]
"""Returns a picture (BGR) of a camera: from the robot's pose, its number, and the camera's name."""
_Answer: TypeAlias = Callable[["SimulatorServicer", Any, Any], Awaitable[Any]]


def _get(topic: str, build: Callable[["SimulatorServicer"], Any]) -> _Answer:
    """Return a method that answers when a topic has changed after the request's cursor."""

    async def answer(self: "SimulatorServicer", request: pb2.GetRequest, _context: Any) -> Any:
        self.count(topic)
        cursor = await self.changed(topic, request.metadata.cursor)
        response = build(self)
        response.metadata.cursor = cursor
        return response

    return answer


class SimulatorServicer(KachakaApiServicer):
    """The service; `run` has to run. What it does not have is answered UNIMPLEMENTED, as by the vendor's base class.

    Args:
        robot: that is simulated.
        pace: seconds of the robot that pass in one.
        picture: draws what its cameras see.
        frame_rate: pictures a second of each camera.
        clock: seconds, of the cursors too.

    Attributes:
        robot: likewise.
        calls: how often each topic and camera was asked for.
        map_data: what `GetPngMap` has instead of the house's map, for tests of large ones.
    """

    def __init__(
        self,
        robot: SimulatedKachaka,
        pace: float = 1.0,
        picture: Picture | None = None,
        frame_rate: float = FRAME_RATE,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.robot = robot
        self.calls: dict[str, int] = {}
        self.map_data = b""
        self._pace = pace
        self._picture: Picture = picture or partial(draw, robot.house)
        self._frame_rate = frame_rate
        self._clock = clock
        self._began = clock()
        self._changed = asyncio.Event()
        self._is_closing = False

    async def run(self) -> None:
        """Let time pass until cancelled."""
        while True:
            self.step()
            await asyncio.sleep(_TICK)

    def step(self) -> None:
        """Let the robot go on to the present, and wake what waits for a change."""
        now = self._clock()
        # The cursors have the robot's clock, which goes `pace` times as fast, and all of them the same.
        self.robot.advance(self._began + (now - self._began) * self._pace)
        woken, self._changed = self._changed, asyncio.Event()
        woken.set()

    def count(self, topic: str) -> None:
        """Count a request."""
        self.calls[topic] = self.calls.get(topic, 0) + 1

    async def changed(self, topic: str, cursor: int) -> int:
        """Return the cursor of a topic when it has changed after `cursor`."""
        topics = self.robot.topics
        while not self._is_closing and not topics.is_news(topic, cursor):
            await self._changed.wait()
        return topics.cursor(topic)

    def close(self) -> None:
        """Answer what waits for a change: gRPC complains of each request that it has to cancel."""
        self._is_closing = True
        self._changed.set()

    # Whether each has a topic of its own is our reading of the vendor's client.

    GetRobotSerialNumber = _get("still", lambda _self: pb2.GetRobotSerialNumberResponse(serial_number="SIMULATED"))
    GetRobotVersion = _get("still", lambda _self: pb2.GetRobotVersionResponse(version="3.17.5"))
    GetRobotPose = _get("pose", lambda self: pb2.GetRobotPoseResponse(pose=_pose(self.robot.body.pose)))
    GetBatteryInfo = _get("battery", lambda self: _battery(self.robot))
    GetError = _get("error", lambda self: pb2.GetErrorResponse(error_codes=map(int, self.robot.errors)))
    GetCommandState = _get("state", lambda self: _state(self.robot))
    GetLastCommandResult = _get("result", lambda self: _last_result(self.robot))
    GetHistoryList = _get("history", lambda self: _history(self.robot))
    GetLocations = _get("still", lambda self: _locations(self.robot))
    GetShelves = _get("shelves", lambda self: _shelves(self.robot))
    GetMovingShelfId = _get(
        "moving_shelf", lambda self: pb2.GetMovingShelfIdResponse(shelf_id=self.robot.premises.carried)
    )
    GetManualControlEnabled = _get(
        "manual", lambda self: pb2.GetManualControlEnabledResponse(enabled=self.robot.manual.is_on(self.robot.now))
    )
    GetSpeakerVolume = _get("volume", lambda self: pb2.GetSpeakerVolumeResponse(volume=self.robot.volume))
    GetObjectDetection = _get("detection", lambda self: _detections(self.robot))
    GetCurrentMapId = _get("still", lambda _self: pb2.GetCurrentMapIdResponse(id="M01"))
    GetPngMap = _get("still", lambda self: pb2.GetPngMapResponse(map=_map(self.robot, self.map_data)))
    GetSoundList = _get(
        "still",
        lambda _self: pb2.GetSoundListResponse(sounds=[pb2.Sound(id=id, name=name) for id, name in _SOUNDS]),
    )
    GetFrontCameraRosCameraInfo = _get(
        "still", lambda _self: pb2.GetFrontCameraRosCameraInfoResponse(camera_info=_camera_info("camera_front_link"))
    )
    GetBackCameraRosCameraInfo = _get(
        "still", lambda _self: pb2.GetBackCameraRosCameraInfoResponse(camera_info=_camera_info("camera_back_link"))
    )

    async def GetFrontCameraRosCompressedImage(self, request: pb2.GetRequest, _context: Any) -> Any:  # noqa: N802
        """Return the next picture of the front camera."""
        cursor, image = await self._image("front", request.metadata.cursor)
        metadata = pb2.Metadata(cursor=cursor)
        return pb2.GetFrontCameraRosCompressedImageResponse(metadata=metadata, image=image)

    async def GetBackCameraRosCompressedImage(self, request: pb2.GetRequest, _context: Any) -> Any:  # noqa: N802
        """Return the next picture of the back camera."""
        cursor, image = await self._image("back", request.metadata.cursor)
        metadata = pb2.Metadata(cursor=cursor)
        return pb2.GetBackCameraRosCompressedImageResponse(metadata=metadata, image=image)

    async def IsReady(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        """Return that it is ready."""
        self.count("is_ready")
        return pb2.IsReadyResponse(ready=not self.robot.errors)

    async def GetRobotErrorCodeJson(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        """Return all error codes with their texts."""
        self.count("error_texts")
        return pb2.GetRobotErrorCodeJsonResponse(json=error_code_json(), result=_result(ErrorCode.NONE))

    async def StartCommand(self, request: pb2.StartCommandRequest, _context: Any) -> Any:  # noqa: N802
        """Accept a command."""
        self.step()
        error, command_id = self.robot.start(request.command, cancel_all=request.cancel_all)
        return pb2.StartCommandResponse(result=_result(error), command_id=command_id)

    async def CancelCommand(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        """Cancel the command that runs."""
        self.step()
        job = self.robot.cancel()
        return pb2.CancelCommandResponse(result=_result(ErrorCode.NONE), command=job.command if job else None)

    async def SetManualControlEnabled(self, request: Any, _context: Any) -> Any:  # noqa: N802
        """Switch manual control."""
        self.step()
        return pb2.SetManualControlEnabledResponse(result=_result(self.robot.set_manual(request.enable)))

    async def SetRobotVelocity(self, request: Any, _context: Any) -> Any:  # noqa: N802
        """Go with a velocity."""
        self.step()
        return pb2.SetRobotVelocityResponse(result=_result(self.robot.set_velocity(request.linear, request.angular)))

    async def SetEmergencyStop(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        """Stop in an emergency."""
        self.step()
        self.robot.stop_in_emergency()
        return pb2.SetEmergencyStopResponse(result=_result(ErrorCode.NONE))

    async def SetSpeakerVolume(self, request: Any, _context: Any) -> Any:  # noqa: N802
        """Set the volume."""
        self.robot.set_volume(request.volume)
        return pb2.SetSpeakerVolumeResponse(result=_result(ErrorCode.NONE))

    async def PlaySound(self, request: Any, _context: Any) -> Any:  # noqa: N802
        """Play a sound."""
        if request.sound_id not in dict(_SOUNDS):
            return pb2.PlaySoundResponse(result=_result(ErrorCode.UNKNOWN_TARGET))
        self.robot.sounds.append(request.sound_id)
        return pb2.PlaySoundResponse(result=_result(ErrorCode.NONE))

    async def StopSound(self, _request: Any, _context: Any) -> Any:  # noqa: N802
        """Stop sounds."""
        self.count("stop_sound")
        return pb2.StopSoundResponse(result=_result(ErrorCode.NONE))

    async def SetFrontTorchIntensity(self, request: Any, context: Any) -> Any:  # noqa: N802
        """Set the light in front."""
        await self._light("front", request.intensity, context)
        return pb2.SetFrontTorchIntensityResponse(result=_result(ErrorCode.NONE))

    async def SetBackTorchIntensity(self, request: Any, context: Any) -> Any:  # noqa: N802
        """Set the light behind."""
        await self._light("back", request.intensity, context)
        return pb2.SetBackTorchIntensityResponse(result=_result(ErrorCode.NONE))

    async def _light(self, name: str, intensity: int, context: Any) -> None:
        if not self.robot.settings.torches:
            await context.abort(grpc.StatusCode.UNIMPLEMENTED, "this robot has no torches")
        self.robot.lights[name] = intensity

    async def _image(self, name: str, cursor: int) -> tuple[int, pb2.RosCompressedImage]:
        """Return the cursor and the picture that is due after a cursor: the present one after 0."""
        self.count(name)
        number = int(self._clock() * self._frame_rate)
        if cursor >= self._frame_cursor(number):
            number = int(cursor / 1e6 * self._frame_rate) + 1
            await asyncio.sleep(max(0.0, number / self._frame_rate - self._clock()))
        pose = self.robot.body.pose
        if name == "back":
            pose = Pose(pose.x, pose.y, pose.th + np.pi)
        data = await asyncio.to_thread(lambda: encode(self._picture(pose, number, name)))
        header = pb2.RosHeader(stamp_nsec=time.time_ns(), frame_id=f"camera_{name}_link")
        return self._frame_cursor(number), pb2.RosCompressedImage(header=header, format="jpeg", data=data)

    def _frame_cursor(self, number: int) -> int:
        """Return the cursor of a picture: the moment at which it was due, and a little, so that it rounds to it."""
        return int((number + 0.01) / self._frame_rate * 1e6)


@asynccontextmanager
async def serve_simulator(servicer: SimulatorServicer, host: str = "127.0.0.1", port: int = 0) -> AsyncIterator[int]:
    """Serve a simulated robot while the block runs, and yield its port.

    Args:
        servicer: of the robot.
        host: address to listen at.
        port: 0: any that is free.

    Raises:
        OSError: nothing can listen there.
    """
    _require_free(host, port)
    sizes = [("grpc.max_send_message_length", _LARGEST), ("grpc.max_receive_message_length", _LARGEST)]
    server = grpc.aio.server(options=[*sizes, ("grpc.so_reuseport", 0)])
    add_KachakaApiServicer_to_server(servicer, server)  # type: ignore[no-untyped-call]
    try:
        bound = server.add_insecure_port(f"{host}:{port}")
    except RuntimeError as error:
        raise OSError(f"nothing can listen at {host}:{port}: {error}") from None
    await server.start()
    running = asyncio.ensure_future(servicer.run())
    try:
        yield bound
    finally:
        running.cancel()
        with suppress(asyncio.CancelledError):
            await running
        servicer.close()
        await server.stop(_GRACE)


def _result(error: ErrorCode) -> pb2.Result:
    return pb2.Result(success=error is ErrorCode.NONE, error_code=int(error))


def _pose(pose: Pose) -> pb2.Pose:
    return pb2.Pose(x=pose.x, y=pose.y, theta=pose.th)


def _battery(robot: SimulatedKachaka) -> pb2.GetBatteryInfoResponse:
    charges = robot.premises.is_docked
    status = pb2.POWER_SUPPLY_STATUS_CHARGING if charges else pb2.POWER_SUPPLY_STATUS_DISCHARGING
    return pb2.GetBatteryInfoResponse(remaining_percentage=robot.battery, power_supply_status=status)


def _state(robot: SimulatedKachaka) -> pb2.GetCommandStateResponse:
    if not robot.jobs:
        return pb2.GetCommandStateResponse(state=pb2.COMMAND_STATE_PENDING)
    job = robot.jobs[0]
    state = pb2.COMMAND_STATE_RUNNING if job.has_begun else pb2.COMMAND_STATE_PENDING
    return pb2.GetCommandStateResponse(state=state, command=job.command, command_id=job.id)


def _last_result(robot: SimulatedKachaka) -> pb2.GetLastCommandResultResponse:
    if robot.last is None:
        return pb2.GetLastCommandResultResponse()
    last = robot.last
    return pb2.GetLastCommandResultResponse(result=_result(last.error), command=last.command, command_id=last.id)


def _history(robot: SimulatedKachaka) -> pb2.GetHistoryListResponse:
    return pb2.GetHistoryListResponse(
        histories=[
            pb2.History(
                id=each.id,
                command=each.command,
                success=each.error is ErrorCode.NONE,
                error_code=int(each.error),
                command_executed_time=int(each.at * 1e9),
            )
            for each in robot.history
        ]
    )


def _locations(robot: SimulatedKachaka) -> pb2.GetLocationsResponse:
    kinds = {(True, False): pb2.LOCATION_TYPE_CHARGER, (False, True): pb2.LOCATION_TYPE_SHELF_HOME}
    locations = [
        pb2.Location(
            id=each.id,
            name=each.name,
            pose=_pose(each.pose),
            type=kinds.get((each.is_charger, each.is_shelf_home), pb2.LOCATION_TYPE_UNSPECIFIED),
        )
        for each in robot.house.locations
    ]
    return pb2.GetLocationsResponse(locations=locations, default_location_id=robot.house.locations[0].id)


def _shelves(robot: SimulatedKachaka) -> pb2.GetShelvesResponse:
    size = pb2.ShelfSize(width=0.36, depth=0.36, height=0.6)
    return pb2.GetShelvesResponse(
        shelves=[
            pb2.Shelf(
                id=each.id,
                name=each.name,
                pose=_pose(robot.premises.shelf_poses[each.id]),
                size=size,
                home_location_id=each.home,
            )
            for each in robot.house.shelves
        ]
    )


def _detections(robot: SimulatedKachaka) -> pb2.GetObjectDetectionResponse:
    header = pb2.RosHeader(stamp_nsec=time.time_ns(), frame_id="camera_front_link")
    objects = [
        pb2.ObjectDetection(
            label=pb2.OBJECT_LABEL_PERSON,
            roi=pb2.RegionOfInterest(x_offset=seen.left, y_offset=seen.top, width=seen.width, height=seen.height),
            score=0.9,
            distance_median=seen.distance,
        )
        for seen in persons_in_view(robot.house, robot.body.pose)
    ]
    return pb2.GetObjectDetectionResponse(header=header, objects=objects)


def _map(robot: SimulatedKachaka, data: bytes) -> pb2.Map:
    grid = robot.house.grid()
    if not data:
        _, png = cv2.imencode(".png", grid)
        data = png.tobytes()
    rows, columns = grid.shape
    return pb2.Map(
        data=data,
        name="home",
        resolution=robot.house.resolution,
        width=columns,
        height=rows,
        origin=_pose(robot.house.origin),
    )


def _camera_info(frame: str) -> pb2.RosCameraInfo:
    width, height = SIZE
    return pb2.RosCameraInfo(
        header=pb2.RosHeader(frame_id=frame),
        width=width,
        height=height,
        K=[FOCAL, 0, width / 2, 0, FOCAL, height / 2, 0, 0, 1],
    )


def _require_free(host: str, port: int) -> None:
    """Raise `OSError` where nothing can listen: a server of gRPC that could not may spin when its process ends."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        # As gRPC does: a port with connections in TIME_WAIT counts as free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host.strip("[]"), port))
        except OSError as error:
            raise OSError(f"nothing can listen at {host}:{port}: {error.strerror}") from None
