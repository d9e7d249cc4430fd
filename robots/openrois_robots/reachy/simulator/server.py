"""The simulated daemon's REST and WebSocket, as far as an adapter speaks to them."""

import asyncio
import json
import time
import uuid
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from math import inf
from typing import Any, Final

from aiohttp import web

from openrois_robots.reachy.postures.posture import Posture
from openrois_robots.reachy.simulator.model import GO_TO_SLEEP, WAKE_UP, Leg, SimulatedReachy
from openrois_robots.reachy.simulator.sounds import Sounds

__all__ = ["SimulatedDaemon", "serve_simulator"]

_STEP: Final = 0.02
_STATUS: Final = 1.0
"""Seconds between two messages of the daemon's status."""
_WAITING: Final = 100
"""Messages that wait for a client; the oldest are lost first."""
_LARGEST: Final = 25 << 20


class SimulatedDaemon:
    """The daemon of one simulated robot.

    Args:
        robot: that it moves.

    Attributes:
        sounds: that were uploaded, played and stopped.
        positions: postures of the last control steps, and when each was taken.
    """

    def __init__(self, robot: SimulatedReachy) -> None:
        self.robot = robot
        self.sounds = Sounds(robot)
        self.positions: list[tuple[float, Posture]] = []
        self._clients: set[asyncio.Queue[str]] = set()

    def application(self) -> web.Application:
        """Return the application of the server."""
        made = web.Application(client_max_size=_LARGEST)
        get, post = made.router.add_get, made.router.add_post
        get("/api/daemon/status", self._daemon_status)
        post("/api/daemon/start", self._start)
        post("/api/daemon/stop", self._stop)
        get("/api/media/status", self.sounds.tell_status)
        post("/api/media/sounds/upload", self.sounds.upload)
        made.router.add_delete("/api/media/sounds/{name}", self.sounds.delete)
        post("/api/media/play_sound", self._working(self.sounds.play))
        post("/api/media/stop_sound", self._working(self.sounds.silence))
        get("/api/motors/status", self._working(self._motors))
        post("/api/motors/set_mode/{mode}", self._working(self._set_mode))
        get("/api/move/running", self._running)
        post("/api/move/goto", self._working(self._goto))
        post("/api/move/play/{name}", self._working(self._play_move))
        post("/api/move/play/recorded-move-dataset/{name:.*}", self._download)
        post("/api/move/stop", self._cancel)
        get("/api/state/doa", self._working(self._doa))
        get("/ws/sdk", self._socket)
        return made

    async def run(self) -> None:
        """Let time pass until cancelled."""
        told_at = -inf
        while True:
            begun = time.monotonic()
            if self.robot.state == "running":
                self._step(begun)
                if begun - told_at >= _STATUS:
                    told_at = begun
                    self._broadcast(self._status())
            await asyncio.sleep(max(0.0, begun + _STEP - time.monotonic()))

    def _step(self, now: float) -> None:
        self.robot.step(now)
        posture = self.robot.posture
        self.positions.append((now, posture))
        del self.positions[:-5000]
        joints = [posture.body, *(0.0,) * 6]
        self._broadcast(
            {"type": "joint_positions", "head_joint_positions": joints, "antennas_joint_positions": posture.antennas}
        )
        matrix = posture.matrix
        self._broadcast({"type": "head_pose", "head_pose": [matrix[row : row + 4] for row in range(0, 16, 4)]})
        finished, self.robot.finished = self.robot.finished, []
        for task in finished:
            if not task.is_listed:
                told = {"uuid": task.id, "finished": True, "error": None, "timestamp": datetime.now(UTC).isoformat()}
                self._broadcast({"type": "task_progress", **told})

    def _broadcast(self, message: Mapping[str, Any]) -> None:
        text = json.dumps(message)
        for waiting in self._clients:
            if waiting.full():
                waiting.get_nowait()
            waiting.put_nowait(text)

    def _working(self, handle: Callable[[web.Request], Awaitable[web.Response]]) -> Any:
        async def answer(request: web.Request) -> web.Response:
            if self.robot.state != "running":
                return web.json_response({"detail": "Backend not running"}, status=503)
            return await handle(request)

        return answer

    def _status(self) -> dict[str, Any]:
        works = self.robot.state == "running"
        return {
            "type": "daemon_status",
            "robot_name": "simulated",
            "state": self.robot.state,
            "no_media": not self.robot.has_media,
            "media_released": False,
            "backend_status": {"motor_control_mode": self.robot.motors, "error": None} if works else None,
            "error": None,
            "version": "1.12.0",
        }

    async def _daemon_status(self, _request: web.Request) -> web.Response:
        return web.json_response(self._status())

    async def _start(self, _request: web.Request) -> web.Response:
        self.robot.state = "running"
        return web.json_response({"job_id": str(uuid.uuid4())})

    async def _stop(self, _request: web.Request) -> web.Response:
        self.robot.state = "stopped"
        self.robot.tasks.clear()
        # Who was connected stays connected, and is told nothing any more, also after the next start.
        self._clients.clear()
        return web.json_response({"job_id": str(uuid.uuid4())})

    async def _motors(self, _request: web.Request) -> web.Response:
        return web.json_response({"mode": self.robot.motors})

    async def _set_mode(self, request: web.Request) -> web.Response:
        mode = request.match_info["mode"]
        if mode not in ("enabled", "disabled", "gravity_compensation"):
            return web.json_response({"detail": [{"msg": "no such mode"}]}, status=422)
        self.robot.motors, self.robot.target = mode, None
        return web.json_response({"status": f"motors changed to {mode} mode"})

    async def _running(self, _request: web.Request) -> web.Response:
        return web.json_response([{"uuid": task.id} for task in self.robot.tasks if task.is_listed])

    async def _goto(self, request: web.Request) -> web.Response:
        asked = await request.json()
        here, head = self.robot.posture, asked.get("head_pose") or {}
        body = here.body if asked.get("body_yaw") is None else float(asked["body_yaw"])
        right, left = asked.get("antennas") or here.antennas
        roll, pitch, yaw, x, y, z = (float(head.get(name, 0.0)) for name in ("roll", "pitch", "yaw", "x", "y", "z"))
        goal = Posture(roll, pitch, yaw - body, x, y, z, body, right, left)
        return self._begin((Leg(goal, float(asked["duration"])),))

    async def _play_move(self, request: web.Request) -> web.Response:
        name = request.match_info["name"]
        if name == "wake_up":
            return self._begin(WAKE_UP)
        return self._begin(GO_TO_SLEEP, ends_asleep=True)

    def _begin(self, legs: tuple[Leg, ...], *, ends_asleep: bool = False) -> web.Response:
        task_id = str(uuid.uuid4())
        self.robot.begin(task_id, legs, time.monotonic(), is_listed=True, ends_asleep=ends_asleep)
        return web.json_response({"uuid": task_id})

    async def _download(self, _request: web.Request) -> web.Response:
        return web.Response(text="Internal Server Error", status=500)

    async def _cancel(self, request: web.Request) -> web.Response:
        task_id = (await request.json())["uuid"]
        if not self.robot.cancel(task_id):
            return web.Response(text="Internal Server Error", status=500)
        return web.json_response({"message": f"Stopped move with UUID: {task_id}"})

    async def _doa(self, _request: web.Request) -> web.Response:
        angle = self.robot.sound_from
        return web.json_response(None if angle is None else {"angle": angle, "speech_detected": True})

    async def _socket(self, request: web.Request) -> web.WebSocketResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        waiting: asyncio.Queue[str] = asyncio.Queue(_WAITING)
        self._clients.add(waiting)
        sending = asyncio.create_task(_send_all(socket, waiting))
        try:
            async for message in socket:
                with suppress(ValueError, KeyError, TypeError):
                    self._obey(json.loads(message.data))
        finally:
            self._clients.discard(waiting)
            sending.cancel()
            await asyncio.wait((sending,))
        return socket

    def _obey(self, message: Mapping[str, Any]) -> None:
        """Carry out a message of a client; nothing is answered."""
        now, kind = time.monotonic(), message["type"]
        if kind == "set_full_target":
            self.robot.set_target(self._posture(message))
        elif kind == "stop_move":
            self.robot.stop(now)
        elif kind == "set_motor_mode":
            self.robot.motors = str(message["mode"])
        elif kind == "task":
            asked = message["req"]
            self.robot.begin(str(message["uuid"]), (Leg(self._posture(asked), float(asked["duration"])),), now)

    def _posture(self, message: Mapping[str, Any]) -> Posture:
        here = self.robot.target or self.robot.posture
        head = message.get("head") or here.matrix
        body = message.get("body_yaw")
        rows = [head[row : row + 4] for row in range(0, 16, 4)]
        return Posture.from_matrix(rows, here.body if body is None else body, message.get("antennas") or here.antennas)


async def _send_all(socket: web.WebSocketResponse, waiting: asyncio.Queue[str]) -> None:
    with suppress(ConnectionError):
        while True:
            await socket.send_str(await waiting.get())


@asynccontextmanager
async def serve_simulator(daemon: SimulatedDaemon, host: str = "127.0.0.1", port: int = 0) -> AsyncIterator[int]:
    """Serve a daemon for as long as the block runs, and yield the port.

    Raises:
        OSError: it cannot listen there.
    """
    runner = web.AppRunner(daemon.application(), access_log=None, shutdown_timeout=0.1)
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port).start()
        stepping = asyncio.create_task(daemon.run())
        try:
            yield int(runner.addresses[0][1])
        finally:
            stepping.cancel()
            await asyncio.wait((stepping,))
    finally:
        await runner.cleanup()
