"""What holds for every recogniser of speech: PocketSphinx, a server, and the one that tests script."""

from abc import ABC, abstractmethod
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager

import numpy as np
import pytest
from openrois_body.hearing.recognizer import EarsSettings, Expectation, SpeechRecognizer
from openrois_body.hearing.server_ears import ServerEars
from openrois_body.hearing.sphinx import Sphinx

from tests.support.hearing import voice
from tests.support.listening import ScriptedRecognizer
from tests.support.speech_server import speech_server

DICTATION = Expectation(("en",))
COMMANDS = Expectation(("en",), "#JSGF V1.0;\ngrammar robot;\npublic <command> = hello there | stop;\n")
SOUND = voice(0.5)


class RecognizerContract(ABC):
    """The rules, tried on a recogniser that `made` makes."""

    @abstractmethod
    def made(self) -> AbstractAsyncContextManager[SpeechRecognizer]:
        """Make a recogniser that works."""

    @pytest.fixture
    async def recognizer(self) -> AsyncIterator[SpeechRecognizer]:
        async with self.made() as recognizer:
            yield recognizer

    def test_it_is_of_this_machine_and_knows_its_languages(self, recognizer: SpeechRecognizer) -> None:
        assert recognizer.available() == (True, "")
        assert recognizer.destination == ""
        assert recognizer.languages
        assert all(len(language) == 2 and language.islower() for language in recognizer.languages)

    def test_what_cannot_be_expected_is_refused_with_a_reason(self, recognizer: SpeechRecognizer) -> None:
        assert recognizer.refusal(DICTATION) == ""
        assert recognizer.refusal(COMMANDS) == ""
        assert recognizer.refusal(Expectation(("en",), "unknown")) != ""

    @pytest.mark.parametrize("expected", [DICTATION, COMMANDS])
    async def test_an_utterance_becomes_candidates(self, recognizer: SpeechRecognizer, expected: Expectation) -> None:
        guesses: list[str] = []
        async with recognizer.open() as transcriber:
            await transcriber.begin(expected)
            for first in range(0, len(SOUND), 1600):
                assert isinstance(await transcriber.hear(SOUND[first : first + 1600]), str)
            found = await transcriber.finish(guesses.append)
        assert all(isinstance(each, str) and each for each in found)
        assert all(isinstance(each, str) for each in guesses)

    async def test_an_utterance_may_be_given_up_and_be_empty(self, recognizer: SpeechRecognizer) -> None:
        async with recognizer.open() as transcriber:
            await transcriber.begin(DICTATION)
            await transcriber.hear(SOUND)
            await transcriber.begin(COMMANDS)
            await transcriber.hear(np.zeros(0, np.int16))
            assert isinstance(await transcriber.finish(lambda _: None), tuple)

    async def test_it_can_be_opened_again(self, recognizer: SpeechRecognizer) -> None:
        for _ in range(2):
            async with recognizer.open() as transcriber:
                await transcriber.begin(DICTATION)


@pytest.mark.engine
class TestSphinx(RecognizerContract):
    """PocketSphinx in its process."""

    @pytest.fixture(autouse=True)
    def _installed(self, pocketsphinx: None) -> None:
        """It is installed here."""

    @asynccontextmanager
    async def made(self) -> AsyncIterator[SpeechRecognizer]:
        yield Sphinx()


@pytest.mark.engine
class TestServer(RecognizerContract):
    """A server of this machine."""

    @asynccontextmanager
    async def made(self) -> AsyncIterator[SpeechRecognizer]:
        async with speech_server() as server:
            yield ServerEars(EarsSettings(server.address))


class TestScripted(RecognizerContract):
    """The one that tests script."""

    @asynccontextmanager
    async def made(self) -> AsyncIterator[SpeechRecognizer]:
        yield ScriptedRecognizer()
