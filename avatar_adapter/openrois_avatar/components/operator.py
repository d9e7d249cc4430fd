"""Operator: what the adapter hears and sees of the person who operates the avatar. A component of our own."""

import numpy as np
from openrois_streaming.source.loudness import Level
from openrois_streaming.source.source import RawVideo

from openrois.adapter import Component, ComponentFailed, Payload, event, query
from openrois_avatar.devices import Camera, Microphone

__all__ = ["Operator"]


class MicrophoneResult(Payload):
    """What is heard: levels in dB of full scale over the last 0.2 s, -100 for silence."""

    connected: bool
    rms: float
    peak: float


class CameraResult(Payload):
    """What is seen: size in pixels, and how bright the picture is, from 0 to 1."""

    width: int
    height: int
    brightness: float


class Operator(Component, authority="OpenRoIS", function="sensing"):
    """Tells whether the operator's microphone and camera arrive, as uplinks of AudioStreaming and VideoStreaming."""

    def __init__(self, microphone: Microphone, camera: Camera) -> None:
        super().__init__()
        self._microphone = microphone
        self._camera = camera
        microphone.level_changed.add(self._tell)

    @query
    async def microphone(self) -> MicrophoneResult:
        """Return whether a microphone is connected, and how loud it is."""
        level = self._microphone.level
        return MicrophoneResult(connected=self._microphone.is_connected, rms=level.rms, peak=level.peak)

    @query
    async def camera(self) -> CameraResult:
        """Look at the next picture of the camera; fails when there is no camera, or no picture for 2 s."""
        if not self._camera.is_connected:
            raise ComponentFailed("no camera is connected")
        try:
            picture = await self._camera.picture()
        except TimeoutError as error:
            raise ComponentFailed("the camera sends no pictures") from error
        return CameraResult(width=picture.width, height=picture.height, brightness=_brightness(picture))

    @event
    def microphone_level(self, rms: float, peak: float) -> None:
        """How loud the microphone is, in dB of full scale (-100: silence): on a change, five times a second at most.

        Args:
            rms: root mean square of the last 0.2 s
            peak: greatest value of the last 0.2 s
        """

    def _tell(self, level: Level) -> None:
        self.microphone_level(level.rms, level.peak)


def _brightness(picture: RawVideo) -> float:
    """The mean of the luma of an I420 picture, which has 16 for black and 235 for white (BT.601)."""
    luma = picture.data[: picture.height] if picture.format == "i420" else picture.data
    return round(min(1.0, max(0.0, (float(np.mean(luma)) - 16) / 219)), 3)
