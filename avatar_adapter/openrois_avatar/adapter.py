"""The avatar adapter put together: one engine, its components, its streams, and the connection to the gateway."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from openrois.application import EngineHost
from openrois.engine import Engine
from openrois.registry import LocalRegistry
from openrois.tasks import TaskScope
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_streaming.clock import SystemClock
from openrois_streaming.codecs import available_codecs
from openrois_streaming.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.synthetic import ColourBars, Tone

from openrois_avatar.components.streaming import Streaming
from openrois_avatar.components.system_information import SystemInformation
from openrois_avatar.settings import AvatarSettings
from openrois_avatar.streams import AvatarStreams, Published

__all__ = ["Avatar", "run_avatar"]


@dataclass(frozen=True, slots=True)
class Avatar:
    host: EngineHost
    video: VideoPublisher
    audio: AudioPublisher
    streams: AvatarStreams


@asynccontextmanager
async def run_avatar(settings: AvatarSettings) -> AsyncIterator[Avatar]:
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        ready = lambda: ComponentStatus.READY
        video = VideoPublisher(ColourBars(clock=clock), clock=clock, stamp=True)
        audio = AudioPublisher(Tone(clock=clock), clock=clock)
        codecs = available_codecs()
        comps = [SystemInformation(settings.engine_id, ready), Streaming("VideoStreaming", tuple(c for c in codecs if c.startswith("video/")), ready), Streaming("AudioStreaming", ("audio/opus",), ready)]
        streams = AvatarStreams(settings.engine_id, {reference(settings.engine_id, "VideoStreaming"): Published(video, "video"), reference(settings.engine_id, "AudioStreaming"): Published(audio, "audio")}, clock)
        await stack.enter_async_context(streams.sessions)
        engine = Engine(settings.engine_id)
        await engine.attach(LocalRegistry(settings.engine_id, comps, extension=streams))
        yield Avatar(EngineHost(engine, tasks), video, audio, streams)
