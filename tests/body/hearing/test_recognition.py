import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import WAITING, Recognition
from openrois_body.hearing.recognizer import Expectation
from openrois_body.hearing.speech_detector import SpeechDetector

from tests.support.hearing import stereo_48k, voice
from tests.support.listening import Listened, ScriptedRecognizer
from tests.support.streaming import settle

SILENCE = np.zeros((48_000, 2), np.int16)
UTTERANCE = np.concatenate([SILENCE[:14_400], stereo_48k(voice(0.8)), SILENCE[:33_600]])


class Office(Listened):
    """A recognition, and its results."""

    def __init__(self) -> None:
        super().__init__()
        self.ear = Ear(self.microphone, self.clock)
        self.hearing = SpeechDetector(self.ear)
        self.recognizer = ScriptedRecognizer()
        self.recognition = Recognition(self.hearing, self.recognizer, self.clock)
        self.recognized: list[tuple[str, ...]] = []
        self.guesses: list[str] = []
        self.failures: list[str] = []
        self.recognition.recognized.add(lambda candidates, _at, _sender: self.recognized.append(candidates))
        self.recognition.guessed.add(lambda guess, _sender: self.guesses.append(guess))
        self.recognition.failed.add(self.failures.append)


@pytest.fixture
async def office() -> AsyncIterator[Office]:
    office = Office()
    running = (asyncio.ensure_future(office.ear.run()), asyncio.ensure_future(office.recognition.run()))
    async with office.plugged(*running):
        yield office
    assert office.recognizer.opened == office.recognizer.closed


async def test_utterances_are_recognised_while_that_is_wanted(office: Office) -> None:
    await office.say(UTTERANCE)
    assert office.recognizer.opened == 0
    leave = office.recognition.want()
    await office.say(UTTERANCE)
    assert office.recognized == [("hello", "hollow")]
    assert office.guesses[:2] == ["h", "he"]
    assert office.recognizer.expected == [Expectation(("en",))]
    # What stood before the first voiced sound is heard, and what came until the end was sure.
    assert 0.8 * 16_000 < office.recognizer.heard[0] < 2.0 * 16_000
    leave()
    leave()
    await settle()
    assert office.recognizer.closed == 1
    await office.say(UTTERANCE)
    assert len(office.recognized) == 1


async def test_two_utterances_and_what_is_expected_of_each(office: Office) -> None:
    office.recognition.want()
    office.recognition.expected = lambda: Expectation(("en",), "first")
    await office.say(UTTERANCE)
    office.recognition.expected = lambda: Expectation(("de",), "second")
    await office.say(UTTERANCE)
    assert [(each.languages, each.grammar) for each in office.recognizer.expected] == [
        (("en",), "first"),
        (("de",), "second"),
    ]
    assert len(office.recognized) == 2


async def test_speech_that_is_not_understood_is_not_told(office: Office) -> None:
    office.recognition.want()
    office.recognizer.understands = ()
    await office.say(UTTERANCE)
    assert office.recognizer.heard
    assert (office.recognized, office.guesses) == ([], [])


async def test_a_quiet_voice_is_made_louder(office: Office) -> None:
    loudest: list[int] = []
    hear = office.recognizer.hear

    async def listening(samples: np.ndarray[tuple[int, ...], np.dtype[np.int16]]) -> str:
        loudest.append(int(np.abs(samples).max()))
        return await hear(samples)

    office.recognizer.hear = listening  # type: ignore[method-assign]
    office.recognition.want()
    await office.say(UTTERANCE // 10)
    assert max(loudest) > 5000
    await office.say(UTTERANCE * 2)
    assert max(loudest) <= 32_768


async def test_an_utterance_that_a_recogniser_fails_at_is_tried_once_more(office: Office) -> None:
    office.recognition.want()
    await settle()
    office.recognizer.failures = 1
    await office.say(UTTERANCE)
    assert office.recognized == [("hello", "hollow")]
    assert office.failures == []
    assert office.recognizer.opened == 2


async def test_an_utterance_that_it_fails_at_again_is_lost_and_the_next_is_not(office: Office) -> None:
    office.recognition.want()
    await settle()
    office.recognizer.failures = 2
    await office.say(UTTERANCE)
    assert office.recognized == []
    assert office.failures == ["it broke"]
    await office.clock.advance(5)
    await office.say(UTTERANCE)
    assert office.recognized == [("hello", "hollow")]
    assert office.recognition.failure == ""


async def test_missing_recogniser_is_reported_while_recognition_is_wanted(office: Office) -> None:
    office.recognizer.installed = False
    leave = office.recognition.want()
    await office.say(UTTERANCE)
    await office.clock.advance(10)
    assert office.recognition.failure == "install it"
    assert 2 <= len(office.failures) <= 6
    leave()
    assert office.recognition.failure == ""
    await office.clock.advance(60)
    known = len(office.failures)
    await office.clock.advance(60)
    assert len(office.failures) == known


async def test_queue_of_utterances_is_bounded_and_the_oldest_is_lost(office: Office) -> None:
    office.recognition.want()
    office.recognizer.held = asyncio.Event()
    for _ in range(WAITING + 2):
        await office.say(UTTERANCE)
    office.recognizer.held.set()
    await settle()
    # The one that was begun, and those that waited.
    assert len(office.recognized) == WAITING + 1
    assert (office.recognition.figures.analysed, office.recognition.figures.lost) == (WAITING + 1, 1)


async def test_no_result_is_announced_after_recognition_is_unwanted(office: Office) -> None:
    leave = office.recognition.want()
    office.recognizer.held = asyncio.Event()
    await office.say(UTTERANCE[:48_000])
    leave()
    office.recognizer.held.set()
    await settle()
    assert (office.recognized, office.guesses) == ([], [])
    assert office.recognizer.closed == 1


async def test_utterance_without_a_recogniser_is_recognised_once_there_is_one(office: Office) -> None:
    office.recognizer.installed = False
    office.recognition.want()
    await office.say(UTTERANCE)
    assert office.recognized == []
    office.recognizer.installed = True
    await office.clock.advance(30)
    assert office.recognized == [("hello", "hollow")]
    assert office.recognition.failure == ""
