"""An adapter whose game engine does WebRTC itself: streams by the engine's own peer connections, commands beside it."""

import asyncio
import logging
import threading
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Final

from openrois_signaling.messages import MediaKind
from openrois_streaming.clock import SystemClock

from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.session.session import EngineHost
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_avatar.components.speech_synthesis import SpeechSynthesis
from openrois_avatar.components.streaming import AudioStreaming, VideoStreaming
from openrois_avatar.components.system_information import SystemInformation
from openrois_avatar.components.teleoperation import Teleoperation
from openrois_avatar.facades.server import StreamerServer, facade_address
from openrois_avatar.facades.streamer import StreamerFactory
from openrois_avatar.facades.streams import FacadeStreams
from openrois_avatar.facades.unity import UnitySender
from openrois_avatar.facades.unreal import UnrealStreamer
from openrois_avatar.health import Health, Observed
from openrois_avatar.metrics.figures import Process, Snapshot, Source
from openrois_avatar.scene import external_scene
from openrois_avatar.settings import AvatarSettings
from openrois_avatar.supervision import Supervised, supervise

__all__ = ["FACADES", "FacadeAvatar", "run_facade"]

_log = logging.getLogger(__name__)

FACADES: Final[dict[str, StreamerFactory]] = {
    "unreal": UnrealStreamer,
    "unity-render-streaming": partial(UnitySender, epoch=time.time),
}
"""Whose signaling server the adapter can be, by the name of the engine."""

_DIRECTIONS: Final = ("recvonly",)


@dataclass(frozen=True, slots=True)
class FacadeAvatar:
    """An adapter that runs: what it serves to a gateway, where its game engine is awaited, and what can be measured."""

    host: EngineHost
    url: str
    look: Callable[[], Awaitable[Snapshot]]


@asynccontextmanager
async def run_facade(settings: AvatarSettings) -> AsyncIterator[FacadeAvatar]:
    """Run an adapter for a game engine that does WebRTC itself, for as long as the block does.

    Raises:
        FacadeUnavailable: the game engine cannot be awaited where it should be.
        LinkError: one cannot listen for its engine link.
        ValueError: the address of the facade is none.
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
        streams.lost()

    def observe() -> Observed:
        # Its pictures cannot be seen from here: being there is all that can be told of it.
        return Observed(None, wanted=False, failure="" if server.streamer is not None else last_words)

    def status() -> ComponentStatus:
        return ComponentStatus.READY if server.streamer is not None else ComponentStatus.ERROR

    server = StreamerServer(
        FACADES[settings.engine], lambda heard: streams.hear(heard), lost, settings.link_secret, clock.now
    )
    streams = FacadeStreams(
        settings.engine_id, kinds, lambda: server.streamer, lambda: last_words, clock, settings.network
    )
    engine = Health("the game engine", clock.now())
    # A voice would have no way to whom it is for, and neither have the hands of who operates.
    async with external_scene(settings.engine_id, settings.link, settings.link_secret, clock) as scene:
        acting = tuple(each for each in scene.components if not isinstance(each, SpeechSynthesis | Teleoperation))
        showing = (VideoStreaming((), _DIRECTIONS, status), AudioStreaming((), _DIRECTIONS, status))
        information = SystemInformation(settings.engine_id, status, scene.place)
        supervised = (Supervised(engine, observe, showing), Supervised(scene.engine, scene.observe, acting))
        async with (
            hosted(settings.engine_id, information, *showing, *acting, extension=streams) as engine_host,
            server.listening(host, port) as url,
            TaskScope() as tasks,
        ):
            _log.info("a game engine is awaited at %s", url)
            tasks.start(streams.run())
            tasks.start(supervise(supervised, clock))

            async def look() -> Snapshot:
                process = Process(
                    len(streams),
                    settings.network.places.applications,
                    len(asyncio.all_tasks()),
                    threading.active_count(),
                )
                return Snapshot(process, (Source("engine", engine.status, 0, None),), (), ())

            yield FacadeAvatar(engine_host, url, look)
