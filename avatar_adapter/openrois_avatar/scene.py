"""What an adapter has to show: an avatar in a game engine, or a test picture with a tone."""

import logging
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.aio.listeners import Listeners
from openrois.component.component import Component
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_avatar.body import Body
from openrois_avatar.components.follow import Follow
from openrois_avatar.components.gaze import Gaze
from openrois_avatar.components.move import Move
from openrois_avatar.components.moving import Figure
from openrois_avatar.components.navigation import Navigation
from openrois_avatar.components.reaction import Reaction
from openrois_avatar.components.scene_senses import scene_senses
from openrois_avatar.components.speech_synthesis import SpeechSynthesis
from openrois_avatar.components.surroundings import Surroundings
from openrois_avatar.components.teleoperation import Teleoperation
from openrois_avatar.components.viewpoint import Viewpoint
from openrois_avatar.health import Health, Observed
from openrois_avatar.legs import Legs
from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_avatar.link.encoded_inlet import EngineEncoded
from openrois_avatar.link.external import ExternalEngine
from openrois_avatar.link.linked import LinkedEngine
from openrois_avatar.link.messages import Event, Hello, Place, VideoShape
from openrois_avatar.pauses import Pauses
from openrois_avatar.sound import AvatarSound
from openrois_avatar.speech.synthesizer import Synthesizer
from openrois_avatar.teleoperation.controls import FigureControls
from openrois_avatar.teleoperation.seat import Seat
from openrois_avatar.voice import Voice
from openrois_avatar.wayfinding import Ways
from openrois_avatar.world import World

__all__ = ["Scene", "embedded_scene", "external_scene", "synthetic_scene"]

_log = logging.getLogger(__name__)

_UNKNOWN: Final = VideoShape(1280, 720, 30.0)
"""What is expected of the pictures of an engine that has not been there yet; the first one shows how it is."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Sources of picture and sound, the components that act in the scene, and how the thing that renders it fares.

    `frame_rate` and `size` (width and height) are of its pictures, as far as is known before there are any.
    `observe` says what is seen of it now, for who keeps `engine` up to date; `pauses` whether its
    pictures are not to be shown now. `hear` lets it hear the operator. `world` is what is known of the scene, `legs`
    move the figure in it, `voice` is what it speaks with; None where there is no figure. `announced` tells of the
    pictures to be expected of another game engine that has come. `seat` says who operates the figure by hand.
    `encoded` has the pictures while it is an engine that encodes them itself. `stamped`: each picture shows its number
    and the time of its capture, to be measured; an avatar's never do.
    """

    video: MediaSource[RawVideo]
    audio: MediaSource[RawAudio]
    frame_rate: float
    size: tuple[int, int]
    components: tuple[Component, ...]
    engine: Health
    observe: Callable[[], Observed]
    pauses: Pauses
    hear: Callable[[RawAudio], None]
    world: World | None = None
    legs: Legs | None = None
    voice: Voice | None = None
    announced: Listeners[VideoShape] = field(default_factory=Listeners)
    seat: Seat | None = None
    encoded: EngineEncoded | None = None
    stamped: bool = False

    def place(self) -> Place | None:
        """Where the figure is, as far as the game engine has told."""
        return None if self.world is None else self.world.place

    def status(self) -> ComponentStatus:
        """How the thing that renders the scene fares."""
        return self.engine.status


def synthetic_scene(
    clock: MediaClock, width: int = 640, height: int = 360, fps: float = 30.0, *, stamped: bool = False
) -> Scene:
    """Return colour bars with a moving dot, and a tone at each whole second; nobody is there to act.

    Args:
        clock: the media clock.
        width: of the picture, in pixels.
        height: of the picture, in pixels.
        fps: pictures per second.
        stamped: whether each shows its number and the time of its capture.
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
    engine_id: str, module: str, clock: MediaClock, address: str | None = None, arguments: Sequence[str] = ()
) -> AbstractAsyncContextManager[Scene]:
    """Show the avatar of an embedded game engine for as long as the block runs.

    Args:
        engine_id: leads the refs of what is in the scene.
        module: the game engine's module; it runs as a child process and is started again when it dies.
        clock: the media clock.
        address: where the engine link listens, as `LinkServer.listen` has it; a private Unix socket if not given.
        arguments: of the game engine.

    Raises:
        LinkError: on entering: the game engine did not start; the text has what it printed last.
    """
    return _engine_scene(engine_id, partial(EmbeddedEngine, module, *arguments, address=address), clock)


def external_scene(engine_id: str, address: str, secret: str, clock: MediaClock) -> AbstractAsyncContextManager[Scene]:
    """Show the avatar of whichever game engine connects to an address, for as long as the block runs.

    Args:
        engine_id: leads the refs of what is in the scene.
        address: where it is awaited, `tcp:host:port` or `unix:/path`.
        secret: what it must know; empty: any will do.
        clock: the media clock.

    Raises:
        LinkError: on entering: one cannot listen there.
    """
    return _engine_scene(
        engine_id, partial(ExternalEngine, address, secret), clock, f"no game engine is connected to {address}"
    )


@asynccontextmanager
async def _engine_scene(
    engine_id: str, make: Callable[..., LinkedEngine], clock: MediaClock, last_words: str = "the game engine is gone"
) -> AsyncIterator[Scene]:
    """Show the avatar of a game engine; `last_words` say why there are no pictures as long as none has been there."""
    async with AsyncExitStack() as stack:
        sound = AvatarSound(clock)
        health = Health("the game engine", clock.now())

        # The body speaks through the engine and hears from it: it is made first and finds the engine when it is there.
        body = Body(lambda command: engine.send(command))
        world = World(engine_id)
        legs = Legs(lambda command: engine.send(command), lambda: walks(), lambda: world.place, clock)

        pauses = Pauses()
        announced: Listeners[VideoShape] = Listeners()

        def told(event: Event) -> None:
            pauses.take(event)
            body.take(event)
            world.take(event)
            legs.take(event)

        def lost(reason: str) -> None:
            nonlocal last_words
            last_words = f"the game engine is gone: {reason}"
            _log.warning("%s", last_words)
            body.lost()
            legs.lost()
            world.clear()
            pauses.clear()

        def back(hello: Hello) -> None:
            body.back(hello.viewpoints)
            announced.tell(hello.video)

        engine = make(on_audio=sound.feed, on_event=told, on_lost=lost, on_back=back, clock=clock)
        await stack.enter_async_context(engine)
        synthesizer = await stack.enter_async_context(Synthesizer(clock))

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
        seat = Seat(reference(engine_id, Teleoperation.component_type.name), clock)
        figure = Figure(legs, world, Ways(world), status)
        components = (
            SpeechSynthesis(voice),
            Reaction(body, reactions, status),
            Gaze(body, status),
            Viewpoint(body, viewpoints, status),
            Teleoperation(seat, FigureControls(legs, body, engine.send, takes_input), status, clock),
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
            engine.hear,
            world,
            legs,
            voice,
            announced,
            seat,
            engine.encoded,
        )
