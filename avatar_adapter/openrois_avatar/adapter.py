"""The avatar adapter put together: one engine, its components, and its streams."""

import logging
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.publisher import AudioPublisher, VideoPublisher

from openrois.adapter.running import hosted
from openrois.application import EngineHost
from openrois.types.references import reference
from openrois_avatar.components.streaming import AudioStreaming, VideoStreaming
from openrois_avatar.components.system_information import SystemInformation
from openrois_avatar.game_engines import choose_game_engine
from openrois_avatar.scene import Scene, embedded_scene, synthetic_scene
from openrois_avatar.settings import AvatarSettings
from openrois_avatar.streams import AvatarStreams, Published

__all__ = ["AUDIO", "VIDEO", "Avatar", "run_avatar", "serve_scene"]

_log = logging.getLogger(__name__)

VIDEO: Final = "VideoStreaming"
AUDIO: Final = "AudioStreaming"
"""The names of the streaming components."""


@dataclass(frozen=True, slots=True)
class Avatar:
    """An avatar adapter that runs: what it serves to a gateway, and what it publishes."""

    host: EngineHost
    video: VideoPublisher
    audio: AudioPublisher


@asynccontextmanager
async def run_avatar(settings: AvatarSettings) -> AsyncIterator[Avatar]:
    """Run the avatar that the settings describe for as long as the block does.

    Raises:
        NoGameEngine: the game engine does not run here; the text says what to install.
        LinkError: it did not start; the text has what it printed last.
        UnsupportedLibrary: the installed aiortc is not one that can be used.
    """
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        if settings.engine == "synthetic":
            scene = synthetic_scene(clock)
        else:
            name, missing = choose_game_engine(settings.engine)
            if missing:
                _log.warning("%s", missing)
            scene = await stack.enter_async_context(embedded_scene(f"openrois_avatar.engines.{name}", clock))
        yield await stack.enter_async_context(serve_scene(settings.engine_id, scene, clock))


@asynccontextmanager
async def serve_scene(engine_id: str, scene: Scene, clock: MediaClock) -> AsyncIterator[Avatar]:
    """Make an engine of a scene: its components, and the streams of its picture and sound.

    Args:
        engine_id: leads every ref.
        scene: what there is to show.
        clock: the media clock of the scene's sources.

    Raises:
        UnsupportedLibrary: the installed aiortc is not one that can be used.
    """
    video = VideoPublisher(scene.video, clock=clock, stamp=True, frame_rate=scene.frame_rate)
    audio = AudioPublisher(scene.audio, clock=clock)
    published = {
        reference(engine_id, VIDEO): Published(video, "video"),
        reference(engine_id, AUDIO): Published(audio, "audio"),
    }
    components = (
        SystemInformation(engine_id, scene.status),
        VideoStreaming(_codecs("video/"), scene.status),
        AudioStreaming(_codecs("audio/"), scene.status),
        *scene.components,
    )
    async with AsyncExitStack() as stack:
        streams = AvatarStreams(engine_id, published, clock)
        await stack.enter_async_context(streams.sessions)
        host = await stack.enter_async_context(hosted(engine_id, *components, extension=streams))
        yield Avatar(host, video, audio)


def _codecs(kind: str) -> tuple[str, ...]:
    return tuple(codec for codec in available_codecs() if codec.startswith(kind))
