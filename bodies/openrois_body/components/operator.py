"""Operator: level and picture of the operator's microphone and camera. A component of OpenRoIS."""

import numpy as np
from openrois_media.devices import Camera, Microphone
from openrois_streaming.source.loudness import Level
from openrois_streaming.source.source import RawVideo

from openrois.adapter import Component, ComponentFailed, Payload, event, query

__all__ = ["Operator"]


class MicrophoneResult(Payload):
    """The microphone: levels in dB of full scale over the last 0.2 s, -100 for silence."""

    connected: bool
    rms: float
    peak: float


class CameraResult(Payload):
    """The camera's picture: size in pixels, and brightness from 0 to 1."""

    width: int
    height: int
    brightness: float


class Operator(Component, authority="OpenRoIS", function="sensing"):
    """Reports on the operator's microphone and camera, which are uplinks of AudioStreaming and VideoStreaming."""

    def __init__(self, microphone: Microphone, camera: Camera) -> None:
        super().__init__()
        self._microphone = microphone
        self._camera = camera
        microphone.level_changed.add(self._on_level_changed)

    @query
    async def microphone(self) -> MicrophoneResult:
        """Return whether a microphone is connected, and how loud it is."""
        level = self._microphone.level
        return MicrophoneResult(connected=self._microphone.is_connected, rms=level.rms, peak=level.peak)

    @query
    async def camera(self) -> CameraResult:
        """Return size and brightness of the camera's next picture; fails without a camera or a picture within 2 s."""
        if not self._camera.is_connected:
            raise ComponentFailed("no camera is connected; connect an uplink of VideoStreaming first")
        try:
            picture = await self._camera.picture()
        except TimeoutError as error:
            raise ComponentFailed("the camera sends no pictures; check that its stream is not suspended") from error
        return CameraResult(width=picture.width, height=picture.height, brightness=_brightness(picture))

    @event
    def microphone_level(self, rms: float, peak: float, visitor_ref: str | None = None) -> None:
        """The level of the microphone, in dB of full scale (-100: silence): on a change, five times a second at most.

        Args:
            rms: root mean square of the last 0.2 s
            peak: greatest value of the last 0.2 s
            visitor_ref: whose it is, where visitors are told apart
        """

    def _on_level_changed(self, level: Level) -> None:
        self.microphone_level(level.rms, level.peak, self._microphone.sender or None)


def _brightness(picture: RawVideo) -> float:
    """Return the mean luma of an I420 picture, which has 16 for black and 235 for white (BT.601)."""
    luma = picture.data[: picture.height] if picture.format == "i420" else picture.data
    return round(min(1.0, max(0.0, (float(np.mean(luma)) - 16) / 219)), 3)
