"""The sounds of the simulated daemon."""

import time
import wave
from io import BytesIO

from aiohttp import BodyPartReader, web

from openrois_robots.reachy.simulator.model import SimulatedReachy

__all__ = ["Sounds"]


class Sounds:
    """Sounds that are uploaded and played.

    Args:
        robot: says whether they are heard.

    Attributes:
        lengths: of the sounds that are there, in seconds, by their names.
        played: sounds that were heard: their names, lengths, and when each began.
        silenced: times at which the sound was stopped.
    """

    def __init__(self, robot: SimulatedReachy) -> None:
        self.lengths: dict[str, float] = {}
        self.played: list[tuple[str, float, float]] = []
        self.silenced: list[float] = []
        self._robot = robot

    async def tell_status(self, _request: web.Request) -> web.Response:
        """Tell whether a sound is heard."""
        has = self._robot.has_media
        return web.json_response({"available": has, "released": False, "no_media": not has})

    async def upload(self, request: web.Request) -> web.Response:
        """Keep a sound."""
        part = await (await request.multipart()).next()
        if not isinstance(part, BodyPartReader) or not part.filename:
            return web.json_response({"detail": "Filename is required"}, status=400)
        try:
            with wave.open(BytesIO(bytes(await part.read()))) as sound:
                self.lengths[part.filename] = sound.getnframes() / sound.getframerate()
        except (wave.Error, EOFError):
            return web.json_response({"detail": "Unsupported or invalid audio file"}, status=400)
        return web.json_response({"status": "ok", "path": f"/tmp/reachy_mini_sounds/{part.filename}"})  # noqa: S108

    async def delete(self, request: web.Request) -> web.Response:
        """Remove a sound."""
        name = request.match_info["name"]
        if self.lengths.pop(name, None) is None:
            return web.json_response({"detail": f"File '{name}' not found"}, status=404)
        return web.json_response({"status": "ok"})

    async def play(self, request: web.Request) -> web.Response:
        """Play a sound: with success, whether it is heard or not."""
        name = (await request.json())["file"]
        if self._robot.has_media and name in self.lengths:
            self.played.append((name, self.lengths[name], time.monotonic()))
        return web.json_response({"status": "ok"})

    async def silence(self, _request: web.Request) -> web.Response:
        """Stop the sound."""
        self.silenced.append(time.monotonic())
        return web.json_response({"status": "ok"})
