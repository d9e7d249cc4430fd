"""Steps of a visitor: meet the avatar, speak through it, and measure sound and mouth."""

import re
from dataclasses import dataclass
from statistics import mean
from typing import Final

from playwright.async_api import expect

from tests.support.browser import PATIENCE, Visit

__all__ = ["SAYING", "Speech", "all_stopped", "aloud", "meet", "outcome", "say", "speak"]

SAYING: Final = "document.querySelector('[data-testid=say-state]').dataset.state"
"""What the page says of speech, in JavaScript."""

_MOUTH: Final = (0.44, 0.44, 0.15, 0.14)
_LOUD: Final = 0.02


@dataclass(frozen=True, slots=True)
class Speech:
    """What was heard and seen of a sentence. Times are in milliseconds.

    Attributes:
        noise: the loudest before, as root mean square of full scale.
        began: from the request to the first sound.
        lasted: from the first sound to the last.
        liveliness: how much more the region of the mouth changed from frame to frame than before.
        mouth_after_sound: from when a tenth of the sound was heard to when a tenth of the mouth's movement was seen; a
            glance to the side or a blink before the first word is no more than that.
    """

    noise: float
    began: float
    lasted: float
    liveliness: float
    mouth_after_sound: float


async def meet(visit: Visit) -> None:
    """Wait until the avatar is seen and can be operated."""
    await visit.plays()
    for item in (visit.item("say-text"), visit.page.locator("button.reaction").first):
        await expect(item).to_be_enabled(timeout=PATIENCE * 1000)


async def say(visit: Visit, text: str) -> None:
    """Type a text and press Enter."""
    await visit.item("say-text").fill(text)
    await visit.item("say-text").press("Enter")


async def aloud(visit: Visit) -> None:
    """Wait until a voice is heard from now on."""
    now = await visit.read("performance.now()")
    await visit.until(f"probe.sound.some(({{ at, rms }}) => at > {now} && rms > {_LOUD})")


async def all_stopped(visit: Visit) -> None:
    """Wait until the red button reports that all has stopped; press it again for what did not confirm in time.

    Raises:
        AssertionError: something does not stop.
    """
    button = visit.item("stop-all")
    for _ in range(5):
        await expect(button).to_have_text(re.compile("[Ss]topped"), timeout=PATIENCE * 1000)
        if await button.inner_text() != "Not stopped":
            return
        await visit.press("stop-all")
    raise AssertionError("a component does not stop")


async def outcome(visit: Visit, component_ref: str, command_type: str) -> str:
    """Return the status of the last command that the page executed on a component."""
    command_id = await visit.until_executed(component_ref, command_type)
    completed = await visit.until_told("rois.command.completed", command_id=command_id)
    return str(completed["status"])


async def speak(visit: Visit, text: str) -> Speech:
    """Say a text to its end; ears and eyes are on the avatar before, meanwhile and afterwards."""
    await visit.listen()
    await visit.watch("mouth", *_MOUTH)
    await visit.plays(30)
    asked = await visit.read("performance.now()")
    await say(visit, text)
    await visit.until(f"{SAYING} === 'done'")
    ended = await visit.read("performance.now()")

    sound = [(each["at"], each["rms"]) for each in await visit.read("probe.sound")]
    heard = [(at, rms) for at, rms in sound if at > asked and rms > _LOUD]
    mouth = [(each["at"], each["step"]) for each in await visit.seen("mouth")]
    before = [step for at, step in mouth if at < asked]
    meanwhile = [(at, step) for at, step in mouth if asked < at < ended]
    still = max(3.0, 1.2 * max(before))
    moved = [(at, step - still) for at, step in meanwhile if step > still]
    return Speech(
        noise=max(rms for at, rms in sound if at < asked),
        began=heard[0][0] - asked,
        lasted=heard[-1][0] - heard[0][0],
        liveliness=mean(step for _, step in meanwhile) / mean(before),
        mouth_after_sound=_tenth(moved) - _tenth(heard),
    )


def _tenth(samples: list[tuple[float, float]]) -> float:
    """Return the moment at which a tenth of the total had come; samples are (moment, amount)."""
    rest = sum(amount for _, amount in samples) / 10
    return next(at for at, amount in samples if (rest := rest - amount) <= 0)
