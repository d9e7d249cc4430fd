"""An adapter for a game engine that does WebRTC itself: streams by the engine, commands by its engine link."""

import asyncio
import logging
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Final

from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.components.system_information import SystemInformation
from openrois_body.components.teleoperation import Teleoperation
from openrois_body.host_body import HostBody
from openrois_body.metrics import body_figures
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.health import Health, Observed
from openrois_media.metrics.figures import Process, Snapshot, Source
from openrois_media.supervision import Supervised, supervise
from openrois_signaling.messages import MediaKind
from openrois_streaming.clock import SystemClock

from openrois.adapter.loading import make_components
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_avatar.facades.server import StreamerServer
from openrois_avatar.facades.streamer import StreamerFactory
from openrois_avatar.facades.streams import FacadeStreams
from openrois_avatar.facades.unity import UnitySender
from openrois_avatar.facades.unreal import UnrealStreamer
from openrois_avatar.options.link_options import facade_address
from openrois_avatar.options.settings import AvatarSettings
from openrois_avatar.scene import external_scene

__all__ = ["FACADES", "FacadeAvatar", "run_facade"]

_log = logging.getLogger(__name__)

FACADES: Final[dict[str, StreamerFactory]] = {
    "unreal": UnrealStreamer,
    "unity-render-streaming": partial(UnitySender, epoch=time.time),
}
"""The signaling servers that the adapter can be, by the name of the engine."""

_DIRECTIONS: Final = ("recvonly",)


@dataclass(frozen=True, slots=True)
class FacadeAvatar:
    """A running adapter: the host for its gateway, the URL for its game engine, and its metrics."""

    host: EngineHost
    url: str
    collect_figures: Callable[[], Awaitable[Snapshot]]


@asynccontextmanager
async def run_facade(settings: AvatarSettings) -> AsyncIterator[FacadeAvatar]:
    """Run an adapter for a game engine that does WebRTC itself, for as long as the block does.

    Raises:
        FacadeUnavailable: the address of the facade cannot be listened on.
        LinkError: the address of the engine link cannot be listened on.
        ValueError: the address of the facade is malformed.
        BadParameter: a component of the user cannot be made; a sentence for a person.
    """
    clock = SystemClock()
    host, port = facade_address(settings.facade)
    video, audio = (
        reference(settings.engine_id, streaming.component_type.name) for streaming in (VideoStreaming, AudioStreaming)
    )
    kinds: dict[str, MediaKind] = {video: "video", audio: "audio"}
    last_words = "no game engine is connected to this adapter's signaling server"

    def lost(reason: str) -> None:
        nonlocal last_words
        last_words = f"the game engine is gone: {reason}"
        streams.engine_lost()

    def observe() -> Observed:
        # Its pictures do not pass through the adapter: only its connection can be observed.
        return Observed(None, wanted=False, failure="" if server.streamer is not None else last_words)

    def status() -> ComponentStatus:
        return ComponentStatus.READY if server.streamer is not None else ComponentStatus.ERROR

    server = StreamerServer(
        FACADES[settings.engine],
        lambda heard: streams.handle_engine_message(heard),
        lost,
        settings.link_secret,
        clock.now,
    )
    streams = FacadeStreams(
        settings.engine_id, kinds, lambda: server.streamer, lambda: last_words, clock, settings.network
    )
    engine = Health("the game engine", clock.now())
    # The voice could not reach the viewers, and input could not reach the adapter.
    async with external_scene(settings.engine_id, settings.link, settings.link_secret, clock) as scene:
        acting = tuple(each for each in scene.components if not isinstance(each, SpeechSynthesis | Teleoperation))
        showing = (VideoStreaming((), _DIRECTIONS, status), AudioStreaming((), _DIRECTIONS, status))
        information = SystemInformation(settings.engine_id, status, scene.place)
        supervised = (Supervised(engine, observe, showing), Supervised(scene.engine, scene.observe, acting))
        own = (information, *showing, *acting)
        added = make_components(settings.components, HostBody(settings.engine_id, clock, own, figure=scene.body), own)
        async with (
            hosted(settings.engine_id, *own, *added, extension=streams) as engine_host,
            server.listening(host, port) as url,
            TaskScope() as tasks,
        ):
            _log.info("a game engine is awaited at %s", url)
            tasks.start(streams.run())
            tasks.start(supervise(supervised, clock))

            async def look() -> Snapshot:
                process = Process(
                    len(streams),
                    settings.network.sessions.applications,
                    len(asyncio.all_tasks()),
                    threading.active_count(),
                )
                return Snapshot(process, (Source("engine", engine.status, 0, None),), (), (), more=body_figures())

            yield FacadeAvatar(engine_host, url, look)
