"""What an adapter has to show: an avatar in a game engine, or a test picture with a tone."""

import logging
from collections.abc import AsyncIterator, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass

from openrois_streaming.clock import MediaClock
from openrois_streaming.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

from openrois.component import Component
from openrois.types.codes import ComponentStatus
from openrois_avatar.body import Body
from openrois_avatar.components.gaze import Gaze
from openrois_avatar.components.reaction import Reaction
from openrois_avatar.components.speech_synthesis import SpeechSynthesis
from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_avatar.sound import AvatarSound
from openrois_avatar.speech.synthesizer import Synthesizer
from openrois_avatar.voice import Voice

__all__ = ["Scene", "embedded_scene", "synthetic_scene"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Scene:
    """Sources of picture and sound, the components that act in the scene, and how the thing that renders it fares."""

    video: MediaSource[RawVideo]
    audio: MediaSource[RawAudio]
    frame_rate: float
    components: tuple[Component, ...]
    status: Callable[[], ComponentStatus]


def synthetic_scene(clock: MediaClock, width: int = 640, height: int = 360) -> Scene:
    """Return colour bars with a moving dot, and a tone at each whole second; nobody is there to act.

    Args:
        clock: the media clock.
        width: of the picture, in pixels.
        height: of the picture, in pixels.
    """
    bars = ColourBars(width, height, clock=clock)
    return Scene(bars, Tone(clock=clock), bars.fps, (), lambda: ComponentStatus.READY)


@asynccontextmanager
async def embedded_scene(module: str, clock: MediaClock) -> AsyncIterator[Scene]:
    """Show the avatar of an embedded game engine for as long as the block runs.

    Args:
        module: the game engine's module; it runs as a child process and is started again when it dies.
        clock: the media clock.

    Raises:
        LinkError: the game engine did not start; the text has what it printed last.
    """
    async with AsyncExitStack() as stack:
        sound = AvatarSound(clock)

        # The body speaks through the engine and hears from it: it is made first and finds the engine when it is there.
        body = Body(lambda command: engine.send(command))

        def lost(reason: str) -> None:
            _log.warning("the game engine is gone: %s", reason)
            body.lost()

        engine = EmbeddedEngine(module, on_audio=sound.feed, on_event=body.take, on_lost=lost, clock=clock)
        await stack.enter_async_context(engine)
        synthesizer = await stack.enter_async_context(Synthesizer(clock))
        greeting = engine.hello
        assert greeting is not None, "entering waits for the greeting"

        def status() -> ComponentStatus:
            return ComponentStatus.READY if engine.hello is not None else ComponentStatus.ERROR

        def reactions() -> tuple[str, ...]:
            return engine.hello.reactions if engine.hello is not None else ()

        components = (
            SpeechSynthesis(Voice(synthesizer, sound, body)),
            Reaction(body, reactions, status),
            Gaze(body, status),
        )
        yield Scene(engine.video, sound, greeting.video.fps, components, status)
