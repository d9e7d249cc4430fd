"""Times of speech on the page and of its notifications, in milliseconds of the page's clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from tests.support.browser import Visit
from tests.support.conversation import SAYING, aloud, say

__all__ = ["AUDIBLE", "PRESS_STOP", "Told", "Utterance", "onsets", "said", "stopped"]

AUDIBLE: Final = 0.003
"""Root mean square of full scale; what Opus makes of silence is below."""
PAUSE: Final = 120.0
"""Milliseconds of silence after which a sound is another one."""

PRESS_STOP: Final = """(() => {
    const pressed = performance.now();
    document.querySelector("[data-testid=say-stop]").click();
    return pressed;
})()"""
"""Presses the page's Stop and gives the moment of that, in JavaScript."""

_VOICE: Final = "avatar/speech_synthesizer"


@dataclass(frozen=True, slots=True)
class Told:
    """A word, and when the page was notified of it."""

    word: str
    at: float


@dataclass(frozen=True, slots=True)
class Utterance:
    """A text that was spoken whole.

    Attributes:
        onsets: when sound began after a pause.
        words: what the page was told of them.
        last_heard: when something was heard for the last time.
        completed: when the page was told that the command is completed.
        playout: milliseconds that the page says its buffer takes.
    """

    onsets: tuple[float, ...]
    words: tuple[Told, ...]
    last_heard: float
    completed: float
    playout: float

    @property
    def lead(self) -> float:
        """By how much `completed` came before the last sound; below zero it came afterwards, as it should."""
        return self.last_heard - self.completed


def onsets(moments: Sequence[float]) -> tuple[float, ...]:
    """The moments, of those at which something was heard, that come after a pause."""
    return (*moments[:1], *(later for earlier, later in pairwise(moments) if later - earlier > PAUSE))


async def _heard_since(visit: Visit, begun: float) -> list[float]:
    sound = await visit.read("probe.sound")
    return [each["at"] for each in sound if each["at"] > begun and each["rms"] > AUDIBLE]


async def said(visit: Visit, text: str) -> Utterance:
    """Say a text to its end, and listen for half a second longer."""
    begun = await visit.read("performance.now()")
    before = len(visit.executed(_VOICE, "start"))
    await say(visit, text)
    await visit.until(f"{SAYING} === 'speaking'")
    await visit.until(f"{SAYING} === 'done'")
    [command_id] = visit.executed(_VOICE, "start")[before:]
    completed = await visit.read(f"probe.told.find(({{ params }}) => params.command_id === '{command_id}').at")
    playout = await visit.read("openrois.audio.playoutDelay")
    await visit.until(f"probe.sound.at(-1).at > {completed} + 500")
    moments = await _heard_since(visit, begun)
    told = [each for each in await visit.read("probe.told") if each["at"] > begun]
    words = [each for each in told if each["params"].get("event_type") == "word_spoken"]
    # The line in which the text was typed hears of each word, and so do the captions.
    words = [each for each in words if each["params"]["subscribe_id"] == words[0]["params"]["subscribe_id"]]
    return Utterance(
        onsets(moments), tuple(_word(each) for each in words), moments[-1], completed, playout if playout else 0.0
    )


def _word(told: dict[str, Any]) -> Told:
    results = {each["name"]: each["value"] for each in told["params"]["results"]}
    return Told(results["word"], told["at"])


async def stopped(visit: Visit, text: str) -> float:
    """Begin to say a text and press Stop; milliseconds from that to the end of what is heard."""
    await say(visit, text)
    await aloud(visit)
    pressed = float(await visit.page.evaluate(PRESS_STOP))
    await visit.until(f"{SAYING} === 'stopped'")
    await visit.until("openrois.audio.track.enabled")  # the buffer has run out
    await visit.until(f"probe.sound.at(-1).at > {pressed} + 500")
    return max(await _heard_since(visit, 0.0)) - pressed
