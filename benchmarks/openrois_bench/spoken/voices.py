"""How soon a voice is heard: from the text to its first piece and to its first loud sample at the body's sound.

`python -m openrois_bench.spoken.voices`, in the repository, measures espeak-ng, and a server on this machine that sends
espeak's sound twice as fast as it is heard. With the options of the voice, as `--voice-url`, it measures that one.
"""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from openrois_body.body import Body
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.contract import SpeechRequest, SpeechSynthesizer, VoiceSettings
from openrois_body.speech.server_voice import ServerVoice
from openrois_body.speech.voice import Voice
from openrois_body.speech_options import VoiceChoice, add_voice_options, voice_choice
from openrois_streaming.clock import SystemClock

from openrois.errors import Aborted
from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import median
from openrois_bench.measuring.result import write_result

if TYPE_CHECKING:
    from aiohttp import web

    from tests.support.speech_server import SpeechServer

SENTENCE: Final = "The quick brown fox jumps over the lazy dog, and it does so every single day of the year. "
TEXTS: Final = {"a sentence": SENTENCE, "4,000 characters": (SENTENCE * 50)[:4000]}
LOUD: Final = 1_000
"""Of 32,767."""
_PIECE: Final = 0.1
"""Seconds of sound that the server sends at a time."""
_FASTER: Final = 2.0


async def pieces(synthesizer: SpeechSynthesizer, text: str) -> tuple[float, float]:
    """Return the seconds from a text to its first sound, and to its last."""
    begun, first = time.monotonic(), 0.0
    async with synthesizer.speak(SpeechRequest(text)) as chunks:
        async for chunk in chunks:
            if not first and len(chunk.samples):
                first = time.monotonic() - begun
    return first, time.monotonic() - begun


async def heard(synthesizer: SpeechSynthesizer, text: str) -> float:
    """Return the seconds from a text to its first loud sample where the body's sound is handed out."""
    sound = BodySound(SystemClock())
    voice = Voice(synthesizer, sound, Body(lambda _command: None))
    async with sound.open() as blocks:
        begun = time.monotonic()
        saying = asyncio.create_task(voice.say(text, ssml=False, language="en", character="default", volume=100))
        async for block in blocks:
            if np.abs(block.samples).max() > LOUD:
                break
        passed = time.monotonic() - begun
        voice.interrupt("it was heard")
        with suppress(Aborted):
            await saying
    return passed


async def figures(synthesizer: SpeechSynthesizer, texts: Mapping[str, str], times: int) -> dict[str, dict[str, float]]:
    """Return the medians of each text."""
    told = {}
    for name, text in texts.items():
        made = [await pieces(synthesizer, text) for _ in range(times)]
        late = [await heard(synthesizer, text) for _ in range(times)]
        told[name] = {
            "first piece after (s)": median([first for first, _ in made]),
            "all pieces after (s)": median([last for _, last in made]),
            "heard after (s)": median(late),
        }
        print(f"{name}: done", file=sys.stderr)
    return told


@asynccontextmanager
async def server_here() -> AsyncIterator[SpeechSynthesizer]:
    """Run a server that sends its sound twice as fast as it is heard."""
    from tests.support.http_answers import begin  # a wheel has no tests
    from tests.support.speech_server import SOUND, speech_server

    async def send(server: "SpeechServer", request: "web.Request") -> "web.StreamResponse":
        sound = (await server.sound(server.asked[-1]["input"])).astype("<i2").tobytes()
        response, size = await begin(request, SOUND), 2 * round(24_000 * _PIECE)
        # What was heard is left in its middle.
        with suppress(ConnectionError):
            for first in range(0, len(sound), size):
                await response.write(sound[first : first + size])
                await asyncio.sleep(_PIECE / _FASTER)
        return response

    async with speech_server() as server, ServerVoice(VoiceSettings(server.address)) as voice:
        server.behaviour = send
        yield voice


async def measure(chosen: VoiceChoice, times: int) -> dict[str, object]:
    """Return all figures: of the voice that was chosen, or of espeak-ng and a server here."""
    async with chosen.make(SystemClock()) as synthesizer:
        await synthesizer.languages()
        told: dict[str, object] = {chosen.name: await figures(synthesizer, TEXTS, times)}
    if chosen == VoiceChoice():
        async with server_here() as voice:
            # A long text takes as long as its server wants.
            told["a server on this machine"] = await figures(voice, {"a sentence": SENTENCE}, times)
    return told


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.spoken.voices", description=__doc__)
    add_voice_options(parser)
    parser.add_argument("--times", type=int, default=20, help="of each text (%(default)s)")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    try:
        voice = voice_choice(chosen)
    except ValueError as error:
        parser.error(str(error))
    before = load()
    told = asyncio.run(measure(voice, chosen.times))
    print(json.dumps(told, indent=1))
    write_result(chosen.json, "openrois_bench.spoken.voices", conditions(before), summary=told)


if __name__ == "__main__":
    main()
