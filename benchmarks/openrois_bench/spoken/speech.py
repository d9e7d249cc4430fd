"""Timing of the avatar's speech in Chromium: `completed` and the last sound, `stop` and silence, words and events.

`python -m openrois_bench.spoken.speech`, in the repository, with Chromium installed; `--quick` for a first look. A demo
with the chosen game engine is started; what its page plays is listened to past the page. It is taken off the track: the
delay of a sound device comes on top, for which `completed` waits as well.
"""

import argparse
import asyncio
import json
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import median
from openrois_bench.measuring.result import write_result

if TYPE_CHECKING:
    from tests.support.speech_timing import Utterance

COUNTED = "One. Two. Three. Four. Five. Six."
STORY = "Once upon a time there was an avatar that told long stories to whoever would listen. " * 3
WITHOUT_HUSH = "openrois.audio.hush = () => Promise.resolve()"


def told(values: Sequence[float]) -> dict[str, float]:
    """Median, least and most, in whole milliseconds."""
    whole = [round(each) for each in values]
    return {"median": median(whole), "least": min(whole), "most": max(whole), "runs": len(whole)}


def words_late(utterance: "Utterance") -> list[float]:
    """By how much the page is told of a word after its sound begins; empty where not every word is a sound."""
    if len(utterance.onsets) != len(utterance.words):
        return []
    return [word.at - onset for word, onset in zip(utterance.words, utterance.onsets, strict=True)]


async def measure(chromium: Path, page: str, runs: int) -> dict[str, object]:
    """All figures of one demo."""
    from tests.support.browser import running_browser, visiting  # a wheel has no tests
    from tests.support.conversation import meet
    from tests.support.speech_timing import said, stopped

    utterances, stops, buffered = [], [], []
    async with running_browser(chromium) as browser, visiting(browser, page) as visit:
        await meet(visit)
        await visit.listen()
        await visit.plays(60)
        for number in range(runs):
            utterances.append(await said(visit, COUNTED))
            stops.append(await stopped(visit, STORY))
            print(f"{number + 1} of {runs}: {utterances[-1].lead:.0f} ms, {stops[-1]:.0f} ms", file=sys.stderr)
        await visit.page.evaluate(WITHOUT_HUSH)
        for _ in range(runs):
            buffered.append(await stopped(visit, STORY))
    late = [each for utterance in utterances for each in words_late(utterance)]
    return {
        "completed after the last sound (ms)": told([-each.lead for each in utterances]),
        "the viewer's buffer, as it says (ms)": told([each.playout for each in utterances]),
        "a word told after its sound began (ms)": told(late) if late else None,
        "Stop to silence (ms)": told(stops),
        "Stop to silence, without hush (ms)": told(buffered),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.spoken.speech", description=__doc__)
    parser.add_argument("--engine", default="puppet", help="the game engine of the demo")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--quick", action="store_true", help="two runs of each")
    parser.add_argument("--json", type=Path, help="where the figures are written to")
    chosen = parser.parse_args(arguments)
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        parser.error("Chromium is needed and not installed (Debian: apt install chromium)")
    require_clone()
    from tests.support.demo import running_demo  # a wheel has no tests

    before = load()
    with tempfile.TemporaryDirectory() as folder, running_demo(Path(folder), chosen.engine) as demo:
        figures = asyncio.run(measure(Path(chromium), demo.page, 2 if chosen.quick else chosen.runs))
    print(json.dumps(figures, indent=1))
    write_result(chosen.json, "openrois_bench.spoken.speech", conditions(before), summary=figures)


if __name__ == "__main__":
    main()
