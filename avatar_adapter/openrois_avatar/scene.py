"""The scene of an adapter: an avatar in a game engine, or a test picture with a tone."""

import logging
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from openrois_body.body import Body
from openrois_body.components.dialogue import Dialogue
from openrois_body.components.follow import Follow
from openrois_body.components.gaze import Gaze
from openrois_body.components.move import Move
from openrois_body.components.moving import Figure
from openrois_body.components.navigation import Navigation
from openrois_body.components.reaction import Reaction
from openrois_body.components.scene_senses import scene_senses
from openrois_body.components.speech_stream import SpeechStream
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.components.surroundings import Surroundings
from openrois_body.components.teleoperation import Teleoperation
from openrois_body.messages import Event
from openrois_body.motion.legs import Legs
from openrois_body.motion.wayfinding import Ways
from openrois_body.motion.world import World
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speech_control import SpeechControl
from openrois_body.speech.voice import Voice
from openrois_body.speech_options import VoiceChoice
from openrois_body.teleoperation.figure_controls import FigureControls
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_media.health import Health, Observed
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.component.component import Component
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_avatar.components.viewpoint import Viewpoint
from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_avatar.link.encoded_source import EngineEncoded
from openrois_avatar.link.external import ExternalEngine
from openrois_avatar.link.linked_engine import LinkedEngine
from openrois_avatar.link.messages import Event as LinkEvent
from openrois_avatar.link.messages import Hello, Idle, Pause, Place, VideoShape

__all__ = ["Pauses", "Scene", "embedded_scene", "external_scene", "synthetic_scene"]

_log = logging.getLogger(__name__)

_UNKNOWN: Final = VideoShape(1280, 720, 30.0)
"""The expected pictures of an engine that has not connected yet; the first picture shows their true shape."""


class Pauses:
    """Whether the connected game engine has paused its pictures, so that viewers are shown no still picture.

    Attributes:
        on: whether the pictures are paused now.
        changed: called with True when a pause begins, and with False when it ends.
    """

    def __init__(self) -> None:
        self.on = False
        self.changed: Listeners[bool] = Listeners()

    def handle_event(self, event: LinkEvent) -> None:
        """Note a pause that an event of the game engine tells of."""
        if isinstance(event, Pause):
            self._set(event.on)

    def clear(self) -> None:
        """End the pause of a game engine that has disconnected."""
        self._set(False)

    def _set(self, on: bool) -> None:
        if on is not self.on:
            self.on = on
            self.changed.notify_all(on)


@dataclass(frozen=True, slots=True)
class Scene:
    """Sources of picture and sound, the components that act in the scene, and the status of its engine.

    Attributes:
        video: its pictures, as raw frames.
        audio: its sound.
        frame_rate: pictures per second, as far as known before the first picture.
        size: width and height of the pictures, likewise.
        components: the RoIS components that act in the scene.
        engine: the health of the engine that renders it.
        observe: returns what is observed of that engine now, to keep `engine` up to date.
        pauses: whether the engine has paused its pictures.
        send_audio: sends the operator's sound to the engine.
        world: what is known of the scene; None without a figure.
        legs: move the figure in the scene; None without a figure.
        voice: the figure's voice; None without a figure.
        body: the figure's mouth, eyes and reactions; None without a figure.
        announced: called with the pictures to be expected when another game engine has connected.
        operator_control: which application operates the figure by hand; None without a figure.
        speech_control: which application speaks by sound; None without a figure.
        encoded: the pictures of an engine that encodes them itself.
        stamped: whether each picture shows its number and capture time, for measurements; an avatar's never do.
    """

    video: MediaSource[RawVideo]
    audio: MediaSource[RawAudio]
    frame_rate: float
    size: tuple[int, int]
    components: tuple[Component, ...]
    engine: Health
    observe: Callable[[], Observed]
    pauses: Pauses
    send_audio: Callable[[RawAudio], None]
    world: World | None = None
    legs: Legs | None = None
    voice: Voice | None = None
    body: Body | None = None
    announced: Listeners[VideoShape] = field(default_factory=Listeners)
    operator_control: OperatorControl | None = None
    encoded: EngineEncoded | None = None
    speech_control: SpeechControl | None = None
    stamped: bool = False

    def place(self) -> Place | None:
        """Return where the figure is, if the game engine has reported it."""
        return None if self.world is None else self.world.place

    def status(self) -> ComponentStatus:
        """Return the status of the engine that renders the scene."""
        return self.engine.status


def synthetic_scene(
    clock: MediaClock, width: int = 640, height: int = 360, fps: float = 30.0, *, stamped: bool = False
) -> Scene:
    """Return colour bars with a moving dot, and a tone at each whole second, without a figure.

    Args:
        clock: the media clock.
        width: of the picture, in pixels.
        height: of the picture, in pixels.
        fps: pictures per second.
        stamped: whether each picture shows its number and capture time.
    """
    bars = ColourBars(width, height, fps, clock=clock)
    engine = Health("the test picture", clock.now())
    unobserved = Observed(None, wanted=False)
    return Scene(
        bars,
        Tone(clock=clock),
        bars.fps,
        (width, height),
        (),
        engine,
        lambda: unobserved,
        Pauses(),
        lambda _sound: None,
        stamped=stamped,
    )


def embedded_scene(
    engine_id: str,
    module: str,
    clock: MediaClock,
    address: str | None = None,
    arguments: Sequence[str] = (),
    voice: VoiceChoice | None = None,
) -> AbstractAsyncContextManager[Scene]:
    """Show the avatar of an embedded game engine for as long as the block runs.

    Args:
        engine_id: leads the refs of what is in the scene.
        module: the game engine's module; it runs as a child process and is started again when it dies.
        clock: the media clock.
        address: where the engine link listens, as `LinkServer.listen` has it; a private Unix socket if not given.
        arguments: of the game engine.
        voice: what speaks; None: espeak-ng.

    Raises:
        LinkError: on entering: the game engine did not start; the text has its last output.
    """
    return _engine_scene(engine_id, partial(EmbeddedEngine, module, *arguments, address=address), clock, voice)


def external_scene(
    engine_id: str, address: str, secret: str, clock: MediaClock, voice: VoiceChoice | None = None
) -> AbstractAsyncContextManager[Scene]:
    """Show the avatar of a game engine that connects to an address, for as long as the block runs.

    Args:
        engine_id: leads the refs of what is in the scene.
        address: where it is awaited, `tcp:host:port` or `unix:/path`.
        secret: that it has to send; empty: any will do.
        clock: the media clock.
        voice: what speaks; None: espeak-ng.

    Raises:
        LinkError: on entering: the address cannot be listened on.
    """
    return _engine_scene(
        engine_id, partial(ExternalEngine, address, secret), clock, voice, f"no game engine is connected to {address}"
    )


def _pass_on(event: LinkEvent, parts: Iterable[Callable[[Event], None]]) -> None:
    """Pass an engine's event to the parts of its body; `Idle` concerns the link alone."""
    if not isinstance(event, Idle):
        for handle in parts:
            handle(event)


@asynccontextmanager
async def _engine_scene(
    engine_id: str,
    make: Callable[..., LinkedEngine],
    clock: MediaClock,
    speaking: VoiceChoice | None,
    last_words: str = "the game engine is gone",
) -> AsyncIterator[Scene]:
    """Show the avatar of a game engine; `last_words` say why there are no pictures before it has connected."""
    async with AsyncExitStack() as stack:
        sound = BodySound(clock)
        health = Health("the game engine", clock.now())

        # Body and engine need each other: the body is made first, and finds the engine when that is made.
        body = Body(lambda command: engine.send(command))
        world = World(engine_id)
        legs = Legs(lambda command: engine.send(command), lambda: walks(), lambda: world.place, clock)

        pauses = Pauses()
        announced: Listeners[VideoShape] = Listeners()

        def told(event: LinkEvent) -> None:
            _pass_on(event, (pauses.handle_event, body.handle_event, world.handle_event, legs.handle_event))

        def lost(reason: str) -> None:
            nonlocal last_words
            last_words = f"the game engine is gone: {reason}"
            _log.warning("%s", last_words)
            body.engine_lost()
            legs.engine_lost()
            world.clear()
            pauses.clear()

        def back(hello: Hello) -> None:
            body.engine_returned(hello.viewpoints)
            announced.notify_all(hello.video)

        engine = make(on_audio=sound.feed, on_event=told, on_lost=lost, on_back=back, clock=clock)
        await stack.enter_async_context(engine)
        synthesizer = await stack.enter_async_context((speaking or VoiceChoice()).make(clock))

        def observe() -> Observed:
            failure = "" if engine.hello is not None else last_words
            return Observed(engine.last_sign_at, engine.video.received, wanted=not pauses.on, failure=failure)

        def status() -> ComponentStatus:
            return health.status if engine.hello is not None else ComponentStatus.ERROR

        def walks() -> bool:
            return engine.hello is not None and engine.hello.walks

        def takes_input() -> bool:
            return engine.hello is not None and engine.hello.input

        def reactions() -> tuple[str, ...]:
            return engine.hello.reactions if engine.hello is not None else ()

        def viewpoints() -> tuple[str, ...]:
            return engine.hello.viewpoints if engine.hello is not None else ()

        voice = Voice(synthesizer, sound, body)
        tasks = await stack.enter_async_context(TaskScope())
        speech_control = SpeechControl(reference(engine_id, SpeechStream.component_type.name), voice, clock, tasks)
        operator_control = OperatorControl(
            reference(engine_id, Teleoperation.component_type.name),
            clock,
            reference(engine_id, Gaze.component_type.name),
        )
        figure = Figure(legs, world, Ways(world), status)
        components = (
            SpeechSynthesis(voice),
            Dialogue(),
            SpeechStream(speech_control),
            Reaction(body, reactions, status),
            Gaze(body, status),
            Viewpoint(body, viewpoints, status),
            Teleoperation(operator_control, FigureControls(legs, body, engine.send, takes_input), status, clock),
            Navigation(figure),
            Follow(figure),
            Move(figure),
            Surroundings(world, clock, status),
            *scene_senses(world, clock, status),
        )
        shape = _UNKNOWN if engine.hello is None else engine.hello.video
        size = (shape.width, shape.height)
        yield Scene(
            engine.video,
            sound,
            shape.fps,
            size,
            components,
            health,
            observe,
            pauses,
            engine.send_audio,
            world,
            legs,
            voice,
            body,
            announced,
            operator_control,
            engine.encoded,
            speech_control,
        )
