"""What the offline mind understands: phrases by four synthetic voices, through the body's recogniser and its grammar.

`python -m openrois_bench.agents.phrases`, in the repository; Debian's package `flite` has two of the voices, espeak-ng
the others. A phrase is right when the intended thing with the intended name is understood, and nothing else. Other
sentences, noises and silence are false where anything is understood. Persons in rooms are understood worse.
"""

import argparse
import asyncio
import json
import random
import sys
import time
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_agents.mind.phrases import Phrases, make_phrases
from openrois_agents.mind.requests import POLITE_AFTER, POLITE_BEFORE
from openrois_agents.tools.names import Vocabulary
from openrois_body.hearing.recognition import Utterance
from openrois_body.hearing.recognizer import Expectation, Transcriber
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.hearing.voice_activity import PREROLL
from openrois_body.speech.contract import SpeechRequest
from openrois_body.speech.synthesizer import Synthesizer
from openrois_streaming.source.downsample import SPEECH_RATE, Downsampler

from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result
from openrois_bench.spoken.hearing import OTHERS, as_heard, in_noise, pieces_of_speech

__all__ = ["VOCABULARY", "Heard", "Voices", "main", "others_to_say", "phrases_to_say"]

Sound = NDArray[np.int16]

VOCABULARY: Final = Vocabulary(
    bodies=("avatar", "robot"),
    gestures=(
        *("bow", "clap", "glance_at_watch", "look_around", "nod", "raise_hand", "shake_hands", "shake_head"),
        *("shrug", "surprise", "tilt", "wave"),
    ),
    places=(
        *("bookshelf", "coffee table", "counter", "cupboard", "desk", "dock", "fridge", "kitchen table", "lamp"),
        *("pillar", "plant", "radio", "sofa", "stool", "table"),
    ),
)
"""What the avatar and the simulated robot of the demo have."""
VOICES: Final = ("flite slt", "flite rms", "espeak", "espeak f3")
RATIOS: Final = {"clean": None, "30 dB": 30.0}
"""Of speech to white noise."""
_BLOCK: Final = SPEECH_RATE // 10
_SEED: Final = 19


@dataclass(frozen=True, slots=True)
class Heard:
    """What became of one sound: what was understood, and how long it and the recogniser's work took, in seconds."""

    texts: tuple[str, ...]
    pieces: int
    seconds: float
    took: float

    def intents(self, phrases: Phrases) -> list[object]:
        """Return what was meant by all that was understood."""
        return [intent for each in self.texts if (intent := phrases.understand(each)) is not None]


class Voices:
    """Speaks texts by flite and espeak-ng. What was said once is kept."""

    def __init__(self, synthesizer: Synthesizer) -> None:
        self._synthesizer = synthesizer

    async def say(self, voice: str, text: str) -> Sound:
        """Return a text as sound at 16 kHz."""
        from tests.support.hearing import spoken  # a wheel has no tests

        program, _, name = voice.partition(" ")
        if program == "flite":
            return spoken(text, name)
        request = SpeechRequest(text, language="en-us", voice=name or None)
        async with self._synthesizer.speak(request) as chunks:
            samples = np.concatenate([each.samples async for each in chunks])
        return Downsampler().add(np.column_stack([samples, samples]))


def phrases_to_say(phrases: Phrases, count: int) -> list[str]:
    """Return so many of the sentences, the same each time: some of each kind, and polite ones."""
    chosen = random.Random(_SEED)
    named = [each for each, intent in phrases.meanings.items() if intent.name in ("go_to", "find")]
    others = [each for each in phrases.meanings if each not in set(named)]
    requests = sorted(phrases.requests)
    polite = [f"{chosen.choice(POLITE_BEFORE)} {each}" for each in chosen.sample(requests, min(40, len(requests)))]
    polite += [f"{each} {chosen.choice(POLITE_AFTER)}" for each in chosen.sample(requests, min(20, len(requests)))]
    wanted = [*others, *chosen.sample(named, min(50, len(named))), *polite]
    chosen.shuffle(wanted)
    return wanted[:count]


def others_to_say(phrases: Phrases, count: int) -> list[str]:
    """Return so many sentences that are none of the phrases."""
    from tests.support.mouth_sentences import FITTED, JUDGED  # a wheel has no tests

    rest = [*FITTED["en"], *JUDGED["en"]]
    random.Random(_SEED).shuffle(rest)
    return [each for each in (*OTHERS, *rest) if phrases.understand(each) is None][:count]


async def hear(transcriber: Transcriber, expected: Expectation, sound: Sound) -> Heard:
    """Pass a sound on as a body does: each piece of speech in it, amplified, in blocks."""
    began = time.perf_counter()
    pieces = pieces_of_speech(sound)
    texts: list[str] = []
    for begin, end, noticed in pieces:
        utterance = Utterance(0.0, expected)
        piece = as_heard(sound, [(begin, end, noticed)])
        # The first part is what was heard until the speech was noticed; it sets the amplification.
        first = noticed - begin + round(PREROLL * SPEECH_RATE)
        for part in np.split(piece, [first, *range(first + _BLOCK, len(piece), _BLOCK)]):
            utterance.add(part)
        await transcriber.begin(expected)
        for part in utterance.parts:
            await transcriber.hear(part)
        texts += (await transcriber.finish(lambda _: None))[:1]
    return Heard(tuple(texts), len(pieces), len(sound) / SPEECH_RATE, time.perf_counter() - began)


@asynccontextmanager
async def recogniser() -> AsyncIterator[Transcriber]:
    """Run the recogniser; a refused grammar is an error."""
    async with Sphinx().open() as transcriber:
        yield transcriber


async def measure(voices: Sequence[str], said: int, others: int) -> dict[str, Any]:
    """Return all figures."""
    phrases = make_phrases(VOCABULARY)
    expected = Expectation(("en",), phrases.grammar)
    if refusal := Sphinx().refusal(expected):
        raise SystemExit(f"the recogniser refuses the grammar: {refusal}")
    figures: dict[str, Any] = {
        "phrases": min(said, len(phrases_to_say(phrases, said))),
        "sentences that are none": others,
    }
    missed: list[list[object]] = []
    async with Synthesizer() as synthesizer, recogniser() as transcriber:
        speakers = Voices(synthesizer)
        for name, ratio in RATIOS.items():
            counts: dict[str, dict[str, int]] = {}
            for voice in voices:
                right = false = 0
                for text in phrases_to_say(phrases, said):
                    heard = await hear(transcriber, expected, in_noise(await speakers.say(voice, text), ratio))
                    is_right = heard.intents(phrases) == [phrases.understand(text)]
                    right += is_right
                    missed += [] if is_right else [[name, voice, text, heard.texts]]
                for text in others_to_say(phrases, others):
                    heard = await hear(transcriber, expected, in_noise(await speakers.say(voice, text), ratio))
                    false += bool(heard.intents(phrases))
                    missed += [[name, voice, text, heard.texts]] if heard.intents(phrases) else []
                counts[voice] = {"right": right, "false": false}
                print(f"{name}, {voice}: {right} right, {false} false", file=sys.stderr)
            spoken = len(phrases_to_say(phrases, said)) * len(voices)
            figures[name] = {
                **counts,
                "right": sum(each["right"] for each in counts.values()) / spoken,
                "sentences that are none, false": sum(each["false"] for each in counts.values())
                / (others * len(voices)),
                "sounds that are no speech": await noises(transcriber, expected, phrases, ratio),
            }
    return {**figures, "wrong": missed}


async def noises(
    transcriber: Transcriber, expected: Expectation, phrases: Phrases, ratio: float | None
) -> dict[str, float]:
    """Return of how many sounds without speech something was understood, and what the work took."""
    from tests.support.hearing import not_speech  # a wheel has no tests

    heard = [await hear(transcriber, expected, in_noise(each, ratio)) for each in not_speech().values()]
    return {
        "sounds": len(heard),
        "taken for speech": sum(each.pieces > 0 for each in heard),
        "false": sum(bool(each.intents(phrases)) for each in heard),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.agents.phrases", description=__doc__)
    parser.add_argument("--phrases", type=int, default=200, help="how many (%(default)s)")
    parser.add_argument("--others", type=int, default=100, help="sentences that are no phrase (%(default)s)")
    parser.add_argument("--voices", nargs="+", default=VOICES, help="as `flite slt` or `espeak f3` (%(default)s)")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    figures = asyncio.run(measure(chosen.voices, chosen.phrases, chosen.others))
    print(json.dumps(figures, indent=1))
    del figures["wrong"]
    write_result(chosen.json, "openrois_bench.agents.phrases", conditions(before), summary=figures)


if __name__ == "__main__":
    main()
