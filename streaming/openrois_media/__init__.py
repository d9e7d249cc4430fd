"""Streams of any body, at both ends of the RoIS Streaming Interface: sources of an adapter, media of an application.

    from openrois_media import Media, opencv_camera, run

    run(engine_id="porch", streams={"camera": opencv_camera(0)})        # in the adapter

    async with Client() as client, Media(client) as media:              # in the application
        picture = await media.snapshot("porch/camera")

It knows no body: what a body is made of besides its streams lies above it. Names are imported on first use, because the
media plane takes half a second, and commands read their options without it.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from openrois.extras import needing_extra

if TYPE_CHECKING:
    from openrois_streaming.capture.audio import AudioSource
    from openrois_streaming.capture.devices import ffmpeg_input, opencv_camera, v4l2_camera
    from openrois_streaming.capture.pipes import piped_pictures, piped_sound, piped_units
    from openrois_streaming.capture.video import EncodedSource, VideoSource
    from openrois_streaming.network.settings import NetworkSettings

    from openrois.types.codes import Purpose
    from openrois_media.client.media import Media
    from openrois_media.client.speaking import SpokenWord
    from openrois_media.client.visitors import Visitor
    from openrois_media.command import main
    from openrois_media.running import run, serve
    from openrois_media.streams import Stream
    from openrois_media.uplinks import AudioUplink, VideoUplink
    from openrois_media.visitors.registry import VisitorRegistry

__all__ = [
    "AudioSource",
    "AudioUplink",
    "EncodedSource",
    "Media",
    "NetworkSettings",
    "Purpose",
    "SpokenWord",
    "Stream",
    "VideoSource",
    "VideoUplink",
    "Visitor",
    "VisitorRegistry",
    "ffmpeg_input",
    "main",
    "opencv_camera",
    "piped_pictures",
    "piped_sound",
    "piped_units",
    "run",
    "serve",
    "v4l2_camera",
]

_PLACES = {
    "AudioSource": "openrois_streaming.capture.audio",
    "AudioUplink": "openrois_media.uplinks",
    "EncodedSource": "openrois_streaming.capture.video",
    "Media": "openrois_media.client.media",
    "NetworkSettings": "openrois_streaming.network.settings",
    "Purpose": "openrois.types.codes",
    "SpokenWord": "openrois_media.client.speaking",
    "Stream": "openrois_media.streams",
    "VideoSource": "openrois_streaming.capture.video",
    "VideoUplink": "openrois_media.uplinks",
    "Visitor": "openrois_media.client.visitors",
    "VisitorRegistry": "openrois_media.visitors.registry",
    "ffmpeg_input": "openrois_streaming.capture.devices",
    "main": "openrois_media.command",
    "opencv_camera": "openrois_streaming.capture.devices",
    "piped_pictures": "openrois_streaming.capture.pipes",
    "piped_sound": "openrois_streaming.capture.pipes",
    "piped_units": "openrois_streaming.capture.pipes",
    "run": "openrois_media.running",
    "serve": "openrois_media.running",
    "v4l2_camera": "openrois_streaming.capture.devices",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"{__name__} has no {name}")
    with needing_extra("streaming"):
        return getattr(import_module(_PLACES[name]), name)
