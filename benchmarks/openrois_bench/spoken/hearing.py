"""Recognition by the avatar's ears: English that flite speaks, clean and in noise, and sounds that are no speech.

`python -m openrois_bench.spoken.hearing`, in the repository; Debian's package `flite` speaks. Figures are of synthetic
voices: of persons in rooms fewer words are right.
"""

import argparse
import asyncio
import json
import statistics
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.hearing.recognizer import Expectation, Transcriber
from openrois_body.hearing.sphinx import Sphinx
from openrois_body.hearing.voice_activity import END_SILENCE, PREROLL, VoiceActivity

from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result

SPEAKERS: Final = ("slt", "rms", "awb")
EXPECTED: Final = (
    *("go to the window", "go to the door", "stop", "turn left", "turn right and wait", "turn left and wait"),
    *("wave to the people", "come here", "follow me", "look at the picture"),
)
OTHERS: Final = (
    *("hello how are you today", "what time is it", "please open the box", "i would like some coffee"),
    *("the weather is nice", "where is the station", "go home now", "turn it off", "wait a minute please"),
    *("nobody knows the answer", "can you hear me", "we were walking along the river"),
)
GRAMMAR: Final = (
    "#JSGF V1.0;\ngrammar robot;\npublic <command> = go to the (window | door) | stop | turn (left | right) [and wait]"
    " | wave to the people | come here | follow me | look at the picture;\n"
)
COMMANDS, DICTATION = Expectation(("en",), GRAMMAR), Expectation(("en",))
RATIOS: Final = {"clean": None, "20 dB": 20.0, "10 dB": 10.0}
"""Of speech to white noise."""
RATE: Final = 16_000
BLOCK: Final = RATE // 10

Sound = NDArray[np.int16]


def in_noise(sound: Sound, ratio: float | None) -> Sound:
    """Return `sound` between a second of silence and one and a half, all of it in noise."""
    whole = np.concatenate([np.zeros(RATE), sound, np.zeros(RATE * 3 // 2)])
    if ratio is not None:
        power = float(np.mean(sound.astype(float) ** 2)) / 10 ** (ratio / 10)
        whole += np.random.default_rng(len(sound)).normal(0, power**0.5, len(whole))
    return np.asarray(np.clip(whole, -32_768, 32_767), np.int16)


def pieces_of_speech(sound: Sound) -> list[tuple[int, int, int]]:
    """The pieces of `sound` that are taken for speech, in samples: where each begins and ends, and is noticed."""
    activity = VoiceActivity()
    found: list[tuple[int, int, int]] = []
    for start in range(0, len(sound), 160):
        for speaking, at in activity.add(sound[start : start + 160]):
            found = [*found, (at, len(sound), start)] if speaking else [*found[:-1], (found[-1][0], at, found[-1][2])]
    return found


def as_heard(sound: Sound, pieces: Sequence[tuple[int, int, int]]) -> Sound:
    """Return the first piece as a recogniser gets it: from before its beginning until its end is sure."""
    begin, end = pieces[0][:2] if pieces else (0, 0)
    return sound[max(0, begin - round(PREROLL * RATE)) : end + round(END_SILENCE * RATE)]


async def understood(transcriber: Transcriber, sound: Sound, expected: Expectation) -> tuple[tuple[str, ...], float]:
    """The candidates, and the seconds from the last sound to them."""
    await transcriber.begin(expected)
    for start in range(0, len(sound), BLOCK):
        await transcriber.hear(sound[start : start + BLOCK])
    ended = time.perf_counter()
    candidates = await transcriber.finish(lambda _: None)
    return candidates, time.perf_counter() - ended


def wrong_words(said: str, heard: str) -> int:
    """Return how many words have to be changed, added or left out to turn one text into the other."""
    words = heard.split()
    row = list(range(len(words) + 1))
    for number, word in enumerate(said.split(), 1):
        before, row[0] = row[0], number
        for at, other in enumerate(words, 1):
            before, row[at] = row[at], min(row[at] + 1, row[at - 1] + 1, before + (word != other))
    return row[-1]


async def speech(transcriber: Transcriber, speakers: Sequence[str]) -> dict[str, dict[str, float]]:
    """Return recognition rates of phrases, by the ratio of speech to noise."""
    from tests.support.hearing import spoken  # a wheel has no tests

    told = {}
    for name, ratio in RATIOS.items():
        noticed, ends, right, wrong, words, found, accepted = [], [], 0, 0, 0, 0, 0
        for speaker in speakers:
            for phrase in (*EXPECTED, *OTHERS):
                sound = in_noise(spoken(phrase, speaker), ratio)
                pieces = pieces_of_speech(sound)
                found += len(pieces) == 1
                noticed += [(at - begin) / RATE for begin, _, at in pieces]
                sound = as_heard(sound, pieces)
                heard, _ = await understood(transcriber, sound, COMMANDS)
                if phrase in EXPECTED:
                    right += heard[:1] == (phrase,)
                else:
                    accepted += bool(heard)
                free, late = await understood(transcriber, sound, DICTATION)
                wrong += wrong_words(phrase, free[0] if free else "")
                words += len(phrase.split())
                ends.append(late)
        count, expected = len(speakers) * len((*EXPECTED, *OTHERS)), len(speakers) * len(EXPECTED)
        print(f"{name}: done", file=sys.stderr)
        told[name] = {
            "phrases that were one piece of speech": found / count,
            "noticed after, median (s)": statistics.median(noticed),
            "noticed after, at most (s)": max(noticed),
            "of a grammar, right": right / expected,
            "of none, taken for one of it": accepted / (count - expected),
            "dictation, wrong words": wrong / words,
            "dictation, words after the end of the sound, median (s)": statistics.median(ends),
        }
    return told


async def other_sounds(transcriber: Transcriber) -> dict[str, float]:
    """Return how many sounds that are no speech are taken for speech, and for a phrase."""
    from tests.support.hearing import not_speech  # a wheel has no tests

    pieces = recognized = 0
    seconds = 0.0
    for ratio in RATIOS.values():
        for sound in (in_noise(each, ratio) for name, each in not_speech().items() if name != "silence"):
            seconds += len(sound) / RATE
            for begin, end, _ in pieces_of_speech(sound):
                pieces += 1
                heard, _ = await understood(transcriber, as_heard(sound, [(begin, end, 0)]), COMMANDS)
                recognized += bool(heard)
    return {"seconds": seconds, "taken for speech": pieces, "taken for a phrase of the grammar": recognized}


def cost() -> float:
    """Seconds of one core that looking for speech takes in a second of it."""
    from tests.support.hearing import spoken  # a wheel has no tests

    sound = np.concatenate([in_noise(spoken(phrase), 20.0) for phrase in OTHERS])
    begin = time.process_time()
    pieces_of_speech(sound)
    return (time.process_time() - begin) / (len(sound) / RATE)


async def measure(speakers: Sequence[str]) -> dict[str, object]:
    """All figures."""
    begin = time.perf_counter()
    async with Sphinx().open() as transcriber:
        loaded = time.perf_counter() - begin
        return {
            "recogniser ready after (s)": loaded,
            "looking for speech, cores": cost(),
            "speech": await speech(transcriber, speakers),
            "other sounds": await other_sounds(transcriber),
        }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.spoken.hearing", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one speaker in place of three")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    figures = asyncio.run(measure(SPEAKERS[:1] if chosen.quick else SPEAKERS))
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.spoken.hearing", conditions(before), summary=figures)


if __name__ == "__main__":
    main()
