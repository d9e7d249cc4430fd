"""Streams of any body, for its adapter: `run` and `serve` with sources, over the RoIS Streaming Interface.

    from openrois_media import opencv_camera, run

    run(engine_id="porch", streams={"camera": opencv_camera(0)})

It knows no body: what a body is made of besides its streams lies above it.
"""

from openrois_streaming.capture.audio import AudioSource
from openrois_streaming.capture.devices import ffmpeg_input, opencv_camera, v4l2_camera
from openrois_streaming.capture.pipes import piped_pictures, piped_sound, piped_units
from openrois_streaming.capture.video import EncodedSource, VideoSource
from openrois_streaming.network.settings import NetworkSettings

from openrois_media.running import run, serve
from openrois_media.streams import Stream
from openrois_media.uplinks import AudioUplink, VideoUplink

__all__ = [
    "AudioSource",
    "AudioUplink",
    "EncodedSource",
    "NetworkSettings",
    "Stream",
    "VideoSource",
    "VideoUplink",
    "ffmpeg_input",
    "opencv_camera",
    "piped_pictures",
    "piped_sound",
    "piped_units",
    "run",
    "serve",
    "v4l2_camera",
]
