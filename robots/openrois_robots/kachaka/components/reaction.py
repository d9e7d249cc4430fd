"""Reaction: sounds that the robot has, and its lights (component 12)."""

from contextlib import suppress
from typing import Any, Final
from urllib.parse import quote

from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_streaming.clock import MediaClock

from openrois.adapter import BadParameter, RoISError, Unsupported, command, components
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Reaction"]

_LIGHTS: Final = {
    "front_light": ("SetFrontTorchIntensity", pb2.SetFrontTorchIntensityRequest),
    "back_light": ("SetBackTorchIntensity", pb2.SetBackTorchIntensityRequest),
}
_FULL: Final = 255
"""Intensity of a light."""
_FLASH: Final = 1.0
"""Seconds of a flash."""
_LONGEST: Final = 10.0


class Reaction(Acting, components.Reaction):
    """Plays a sound of the robot's list, or flashes one of its lights, where it has them.

    The robot does not tell when a sound is over: `completed` says that it has begun.

    Args:
        robot: the robot.
        commands: at it.
        api: of it.
        clock: the media clock.
    """

    def __init__(self, robot: Kachaka, commands: Commands, api: KachakaApi, clock: MediaClock) -> None:
        super().__init__(robot, commands)
        self._api = api
        self._clock = clock
        self._sounds: dict[str, str] = {}
        self._lights: dict[str, str] | None = None

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a reaction that the robot does not have, once it has told which it has."""
        wanted = changes.get("reaction_ref")
        known = self._known
        if wanted is not None and known and wanted not in known:
            raise BadParameter(f"there is no reaction {wanted!r}; available_reactions lists them")
        return changes

    async def available_reactions(self) -> tuple[str, ...]:
        """Return the refs of the sounds and lights that the robot has."""
        await self.robot.link.during(self._load())
        return tuple(self._known)

    @command(timeout=_LONGEST)
    async def start(self) -> None:
        """Play the chosen reaction.

        Raises:
            BadParameter: none is chosen, or the robot does not have it.
            ComponentFailed: the robot did not do it.
        """
        await self.robot.link.during(self._load())
        chosen = self.reaction_ref or ""
        if chosen in self._sounds:
            await self.robot.link.during(self._play(self._sounds[chosen]))
        elif self._lights and chosen in self._lights:
            await self.robot.link.during(self._flash(self._lights[chosen]))
        else:
            raise BadParameter("reaction_ref is not set, or not offered; available_reactions lists the refs")

    async def stop(self) -> None:
        """Let the robot be silent; `start` ends with ABORT."""
        response: pb2.StopSoundResponse = await self._api.call("StopSound", pb2.StopSoundRequest())
        self.robot.texts.require_success(response.result, "stop its sound")

    @property
    def _known(self) -> dict[str, str]:
        return {**self._sounds, **(self._lights or {})}

    async def _load(self) -> None:
        response: pb2.GetSoundListResponse = await self._api.call("GetSoundList")
        self._sounds = {_ref(f"sound/{each.id}"): each.id for each in response.sounds}
        if self._lights is None:
            self._lights = {_ref(name): name for name in _LIGHTS if await self._has_light(name)}

    async def _has_light(self, name: str) -> bool:
        """Tell whether the robot has a light, by switching it off."""
        method, request = _LIGHTS[name]
        try:
            response = await self._api.call(method, request(intensity=0))
        except Unsupported:
            return False
        return bool(response.result.success)

    async def _play(self, sound_id: str) -> None:
        response: pb2.PlaySoundResponse = await self._api.call("PlaySound", pb2.PlaySoundRequest(sound_id=sound_id))
        self.robot.texts.require_success(response.result, "play the sound")

    async def _flash(self, name: str) -> None:
        method, request = _LIGHTS[name]
        response = await self._api.call(method, request(intensity=_FULL))
        self.robot.texts.require_success(response.result, "switch its light on")
        try:
            await self._clock.sleep_until(self._clock.now() + _FLASH)
        finally:
            with suppress(RoISError):
                await self._api.call(method, request(intensity=0))


def _ref(name: str) -> str:
    return f"urn:x-rois:def:reaction:OpenRoIS::kachaka/{quote(name)}"
