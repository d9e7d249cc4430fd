"""Scenes: sources of pictures and sound, and the speech meanwhile."""

import asyncio
import random
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from openrois_avatar.link.embedded import EmbeddedEngine
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.speaker import DEFAULT_CHARACTER
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech.voice import Voice
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import MediaSource, RawAudio, RawVideo
from openrois_streaming.synthetic import ColourBars, Tone

SPEAKING = ("puppet", "panda3d")
"""The engines whose mouth is measured."""
SCENES = ("synthetic", "engine", *SPEAKING)

LIPS = ("told", "sound")
"""Where the shapes of the mouth come from: told with the sound, or read from it."""

_SYLLABLES = ("pa", "ma", "ba", "papa", "mama", "baba")
_SEED = 1


@dataclass(frozen=True, slots=True)
class Played:
    """Sources of picture and sound."""

    video: MediaSource[RawVideo]
    audio: MediaSource[RawAudio]


class _Shapeless(Synthesizer):
    """A synthesizer whose mouth shapes are not used."""

    tells_visemes = False


@asynccontextmanager
async def played(name: str, lips: str, clock: MediaClock) -> AsyncIterator[Played]:
    """One of `SCENES` for as long as the context lasts, with one of `LIPS` where the avatar speaks."""
    if name == "synthetic":
        yield Played(ColourBars(1280, 720, clock=clock), Tone(clock=clock))
        return
    sound = BodySound(clock)
    module = f"openrois_avatar.engines.{name}" if name in SPEAKING else "openrois_bench.streams.lipsync.engine"
    arguments = ("--size", "640x360") if name in SPEAKING else ()
    async with EmbeddedEngine(module, *arguments, on_audio=sound.feed, clock=clock) as engine:
        if name not in SPEAKING:
            yield Played(engine.video, sound)
            return
        async with (Synthesizer if lips == "told" else _Shapeless)(clock) as synthesizer:
            voice = Voice(synthesizer, sound, Body(engine.send))
            speaking = asyncio.create_task(_speak(voice))
            yield Played(engine.video, sound)
            speaking.cancel()


async def _speak(voice: Voice) -> None:
    """Syllables that begin with closed lips, and pauses of which no two are alike."""
    chosen: Callable[[float, float], float] = random.Random(_SEED).uniform
    order = random.Random(_SEED)
    while True:
        parts = (f"{order.choice(_SYLLABLES)} <break time='{chosen(300, 900):.0f}ms'/>" for _ in range(10))
        text = f"<speak>{' '.join(parts)}</speak>"
        await voice.say(text, ssml=True, language="en", character=DEFAULT_CHARACTER, volume=50)
