"""The avatar adapter: one engine with its components and its streams."""

import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Final

from openrois_body.attention.attention import Attention
from openrois_body.attention.faces import FaceSizes
from openrois_body.backends import chosen
from openrois_body.camera_senses import camera_senses
from openrois_body.components.operator import Operator
from openrois_body.components.speech_progress import SpeechProgress
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.components.system_information import SystemInformation
from openrois_body.components.visitors import Visitors
from openrois_body.host_body import HostBody
from openrois_body.metrics import body_figures
from openrois_body.microphone_senses import microphone_senses
from openrois_body.speech_options import EarsChoice
from openrois_body.vision.backends import FINDERS
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.sighting import Sighting
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.devices import Camera, Microphone
from openrois_media.metrics.figures import Snapshot
from openrois_media.streams import AdapterStreams, Stream, codecs_of
from openrois_media.supervision import Supervised
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.adaptation.viewer import Caps
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.network.settings import NetworkSettings
from openrois_streaming.publish.encoder_limit import ENCODERS_LIMIT, EncoderLimit
from openrois_streaming.publish.passthrough import EncodedPublisher, SwitchingPublisher
from openrois_streaming.publish.publisher import AudioPublisher, VideoPublisher
from openrois_streaming.session.sessions import StreamSessions

from openrois.adapter.loading import make_components
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.contract import Client
from openrois.session.session import EngineHost
from openrois.types.references import reference
from openrois_avatar.engines.selection import choose_game_engine, link_address
from openrois_avatar.link.encoded_source import EngineEncoded
from openrois_avatar.link.messages import VideoShape
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.options.picture_size import size_text
from openrois_avatar.options.pixel_streaming import PixelStreaming
from openrois_avatar.options.settings import DRAWN, AvatarSettings
from openrois_avatar.pixel_streaming.serving import serve_pixel_streaming
from openrois_avatar.scene import Scene, embedded_scene, external_scene, synthetic_scene

__all__ = ["AUDIO", "VIDEO", "Avatar", "run_avatar", "serve_scene"]

_log = logging.getLogger(__name__)

VIDEO: Final = VideoStreaming.component_type.name
AUDIO: Final = AudioStreaming.component_type.name
"""The names of the streaming components."""


@dataclass(frozen=True, slots=True)
class Avatar:
    """A running avatar adapter: the host that it serves to a gateway, and its publishers."""

    host: EngineHost
    video: SwitchingPublisher
    audio: AudioPublisher
    collect_figures: Callable[[], Awaitable[Snapshot]]
    """Takes a snapshot of all metrics."""


@asynccontextmanager
async def run_avatar(settings: AvatarSettings) -> AsyncIterator[Avatar]:
    """Run the avatar that the settings describe for as long as the block does.

    Raises:
        NoGameEngine: the game engine does not run here; the text says what to install.
        LinkError: it did not start, and the text has its last output; or its address cannot be listened on.
        UnsupportedLibrary: the installed version of aiortc is not supported.
        BadParameter: a component of the user cannot be made; a sentence for a person.
    """
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        if settings.engine == "synthetic":
            scene = synthetic_scene(clock, stamped=settings.stamp)
        elif settings.engine == "external":
            awaited = external_scene(settings.engine_id, settings.link, settings.link_secret, clock, settings.voice)
            scene = await stack.enter_async_context(awaited)
        else:
            name, missing = choose_game_engine(settings.engine)
            if missing:
                _log.warning("%s", missing)
            module = f"openrois_avatar.engines.{name}"
            scene = await stack.enter_async_context(
                embedded_scene(
                    settings.engine_id, module, clock, link_address(name), _of_engine(name, settings), settings.voice
                )
            )
        caps = Caps(max_bitrate=settings.max_viewer_bitrate)
        yield await stack.enter_async_context(
            serve_scene(
                settings.engine_id,
                scene,
                clock,
                settings.network,
                lambda _: caps,
                settings.pixel_streaming,
                settings.max_encoders,
                settings.ears,
                settings.components,
            )
        )


def _of_engine(name: str, settings: AvatarSettings) -> tuple[str, ...]:
    """Return the arguments of an embedded game engine."""
    if name not in DRAWN:
        return ()
    return ("--size", size_text(settings.size), *(("--visitor",) if settings.visitor else ()))


@asynccontextmanager
async def serve_scene(
    engine_id: str,
    scene: Scene,
    clock: MediaClock,
    network: NetworkSettings | None = None,
    cap: Callable[[Client], Caps] | None = None,
    streamer: PixelStreaming | None = None,
    max_encoders: int = ENCODERS_LIMIT,
    ears: EarsChoice | None = None,
    added: Sequence[type[Component]] = (),
) -> AsyncIterator[Avatar]:
    """Make an engine of a scene: its components, and the streams of its picture and sound.

    Args:
        engine_id: leads every ref.
        scene: to be shown.
        clock: the media clock of the scene's sources.
        network: how the streams use the network.
        cap: returns the limits of a client's streams; None: as much as its path carries.
        streamer: the signaling server of Pixel Streaming that it also serves; None for none.
        max_encoders: encoders of its picture at a time.
        ears: what recognises speech; None: what is installed.
        added: the classes of components that the user adds.

    Raises:
        UnsupportedLibrary: the installed version of aiortc is not supported.
        BadParameter: an added component cannot be made; a sentence for a person.
    """
    video, audio = _publisher(scene, clock, EncoderLimit(max_encoders)), AudioPublisher(scene.audio, clock=clock)
    visitors = VisitorRegistry(engine_id, clock)
    microphone, camera = Microphone(clock, visitors), Camera(visitors)
    faces = FaceSizes(chosen(FINDERS, CascadeFinder), clock)
    attention = Attention(visitors, microphone, camera, clock, faces)
    streams = AdapterStreams(
        engine_id,
        {
            VIDEO: Stream(video, visitors.cameras, "picture", scene.status),
            AUDIO: Stream(audio, visitors.microphones, "sound"),
        },
        clock=clock,
        network=network,
        cap=cap,
        operator=scene.operator_control,
        speech=scene.speech_control,
    )
    showing = streams.components[VIDEO]
    information, operator = SystemInformation(engine_id, scene.status, scene.place), Operator(microphone, camera)
    listening = ears or EarsChoice()
    eyes = camera_senses(engine_id, camera, clock)
    hearing = microphone_senses(engine_id, microphone, clock, listening.make(), listening.may_send, visitors)
    eyes.watch.seen.add(lambda seen: attention.note_face(seen.visitor_ref, _largest_face(seen)))
    progress = () if scene.voice is None else (SpeechProgress(scene.voice, hearing.speech),)
    sensing = (*eyes.components, *hearing.components)
    visiting = Visitors(engine_id, visitors, attention, sensing)
    own = (information, *streams.components.values(), operator, visiting, *progress, *sensing, *scene.components)
    components = (*own, *make_components(added, HostBody(engine_id, clock, own, scene.voice, scene.body), own))
    # A voice is heard also while nothing moves.
    moving = tuple(each for each in scene.components if not isinstance(each, SpeechSynthesis | SpeechStream))
    streams.supervised["engine"] = Supervised(scene.engine, scene.observe, (showing, *moving))
    async with AsyncExitStack() as stack:
        interface = await stack.enter_async_context(streams)
        sessions = interface.sessions
        if scene.voice is not None:
            scene.voice.playout_delay.observe_sessions(sessions, reference(engine_id, AUDIO))
        host = await stack.enter_async_context(hosted(engine_id, *components, extension=interface))
        tasks = await stack.enter_async_context(TaskScope())
        tasks.start(microphone.listen())
        tasks.start(attention.run())
        tasks.start(eyes.run())
        tasks.start(hearing.run())
        if streamer is not None:
            shown = tuple(reference(engine_id, name) for name in streams.components)
            tasks.start(serve_pixel_streaming(streamer, interface, shown, scene, clock))
        microphone.sound_received.add(scene.send_audio)
        scene.announced.add(lambda shape: _expect(shape, video, showing))
        scene.pauses.changed.add(lambda on: _pause(sessions, reference(engine_id, VIDEO), on))
        senses = {"vision": eyes.watch.figures, "hearing": hearing.recognition.figures}
        operator_figures = None if scene.operator_control is None else scene.operator_control.figures
        speech = scene.speech_control
        spoken = (None, None) if speech is None else (speech.figures, speech.outcomes)
        more = partial(body_figures, senses, operator_figures, *spoken)
        yield Avatar(host, video, audio, streams.collector(more).snapshot)


def _publisher(scene: Scene, clock: MediaClock, encoders: EncoderLimit) -> SwitchingPublisher:
    encoded = scene.encoded or EngineEncoded(clock, PictureDemand(clock))
    return SwitchingPublisher(
        VideoPublisher(
            scene.video,
            clock=clock,
            stamp=scene.stamped,
            frame_rate=scene.frame_rate,
            size=scene.size,
            encoders=encoders,
        ),
        EncodedPublisher(encoded, clock=clock, frame_rate=scene.frame_rate, size=scene.size),
        lambda: encoded.announced is not None,
    )


def _largest_face(seen: Sighting) -> float:
    """Return the share of the picture that the largest face has; 0 without any."""
    return max((each.box.width * each.box.height for each in seen.persons if each.face), default=0.0)


def _expect(shape: VideoShape, video: SwitchingPublisher, showing: VideoStreaming | AudioStreaming) -> None:
    """Another game engine has come, with such pictures."""
    video.expect(shape.fps, (shape.width, shape.height))
    showing.offer_codecs(codecs_of(video))


def _pause(sessions: StreamSessions, component_ref: str, on: bool) -> None:
    """Hold the avatar's pictures, or let them go; what applications send is nothing to its engine."""
    if on:
        sessions.hold(component_ref, "recvonly")
    else:
        sessions.release(component_ref)
