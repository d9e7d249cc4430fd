import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.speech_detector import SpeechDetector

from tests.support.hearing import RATE, stereo_48k, voice
from tests.support.listening import Listened

SILENCE = np.zeros((48_000, 2), np.int16)
VOICE = stereo_48k(voice(1.0))


class Ears(Listened):
    """A speech detector, and its notifications of speech."""

    def __init__(self) -> None:
        super().__init__()
        self.ear = Ear(self.microphone, self.clock)
        self.detector = SpeechDetector(self.ear)
        self.told: list[tuple[str, float]] = []
        self.sound: list[NDArray[np.int16]] = []
        self.detector.speech_began.add(lambda at: self.told.append(("began", at - 1000)))
        self.detector.speech_ended.add(lambda at: self.told.append(("ended", at - 1000)))
        self.detector.speech.add(self.sound.append)

    @property
    def words(self) -> list[str]:
        return [word for word, _ in self.told]


@pytest.fixture
async def ears() -> AsyncIterator[Ears]:
    ears = Ears()
    async with ears.plugged(asyncio.ensure_future(ears.ear.run())):
        yield ears


async def test_no_speech_is_detected_while_no_caller_attends(ears: Ears) -> None:
    await ears.say(np.concatenate([SILENCE, VOICE, SILENCE]))
    assert ears.told == ears.sound == []


async def test_speech_is_told_with_its_times_and_its_sound(ears: Ears) -> None:
    leave = ears.detector.attend()
    await ears.say(np.concatenate([SILENCE, VOICE]))
    during = ears.detector.speaking
    await ears.say(SILENCE)
    assert (during, ears.detector.speaking) == (True, False)
    (began, at), (ended, until) = ears.told
    assert (began, ended) == ("began", "ended")
    assert at == pytest.approx(1.05, abs=0.1)
    assert until == pytest.approx(2.0, abs=0.15)
    sound = np.concatenate(ears.sound)
    # From before its beginning to when its end was sure.
    assert (until - at) + 0.6 < len(sound) / RATE < (until - at) + 1.1
    said = voice(1.0).astype(float)
    match = np.correlate(sound.astype(float), said[4000:8000], "valid")
    assert match.max() == pytest.approx(float((said[4000:8000] ** 2).sum()), rel=0.05)
    leave()
    leave()


async def test_speech_ends_when_the_microphone_is_taken_away(ears: Ears) -> None:
    ears.detector.attend()
    await ears.say(np.concatenate([SILENCE, VOICE[:36_000]]))
    ears.unplug()
    await ears.clock.advance(1.0)
    assert ears.words == ["began", "ended"]
    ears.plug()
    await ears.say(np.concatenate([SILENCE, VOICE, SILENCE]))
    assert ears.words == ["began", "ended"] * 2
    assert ears.told[2][1] > 2.0


async def test_speech_ends_when_the_last_caller_stops_attending(ears: Ears) -> None:
    first, second = ears.detector.attend(), ears.detector.attend()
    await ears.say(np.concatenate([SILENCE, VOICE[:36_000]]))
    first()
    assert ears.words == ["began"]
    second()
    assert ears.words == ["began", "ended"]
    assert ears.told[1][1] == pytest.approx(1.75, abs=0.05)
    assert not ears.detector.speaking
    ears.detector.attend()
    await ears.say(np.concatenate([SILENCE, VOICE, SILENCE]))
    assert ears.words == ["began", "ended"] * 2
