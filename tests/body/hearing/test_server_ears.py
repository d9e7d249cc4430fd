"""Recognition by a server, spoken to over HTTP on this machine."""

import asyncio
import io
import wave
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from aiohttp import web
from openrois_body.components.speech_recognition import SpeechRecognition
from openrois_body.hearing import server_ears as module
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.recognition import Recognition
from openrois_body.hearing.recognizer import OTHER_SPEECH, EarsSettings, Expectation, RecognizerFailed, SpeechRecognizer
from openrois_body.hearing.server_ears import ServerEars
from openrois_body.hearing.speech_detector import SpeechDetector
from openrois_body.microphone_senses import microphone_senses
from openrois_body.services import server as service
from openrois_body.services.address import ServiceAddress

from openrois.types.codes import ComponentStatus
from tests.support.hearing import stereo_48k, voice
from tests.support.http_answers import begin, event, silent
from tests.support.listening import Listened, ScriptedRecognizer
from tests.support.speech_server import Behaviour, SpeechServer, says, speech_server

pytestmark = pytest.mark.engine

DICTATION = Expectation(("en",))
COMMANDS = Expectation(("en", "de"), "#JSGF V1.0;\ngrammar robot;\npublic <command> = go to the (window | door);\n")
SOUND = voice(1.5)


@pytest.fixture
async def server() -> AsyncIterator[SpeechServer]:
    async with asyncio.timeout(60), speech_server() as server:
        yield server


async def understood(
    server: SpeechServer, expected: Expectation = DICTATION, guesses: list[str] | None = None, **settings: Any
) -> tuple[str, ...]:
    async with ServerEars(EarsSettings(server.address, **settings)).open() as transcriber:
        await transcriber.begin(expected)
        for first in range(0, len(SOUND), 4000):
            assert await transcriber.hear(SOUND[first : first + 4000]) == ""
        return await transcriber.finish((guesses if guesses is not None else []).append)


async def refused(server: SpeechServer, behaviour: Behaviour | None = None, **settings: Any) -> str:
    server.behaviour = behaviour
    with pytest.raises(RecognizerFailed) as error:
        await understood(server, **settings)
    return str(error.value).replace(server.address.origin, "ORIGIN")


async def test_an_utterance_is_sent_as_a_wav_file_and_its_text_comes_back_word_by_word(server: SpeechServer) -> None:
    guesses: list[str] = []
    assert await understood(server, guesses=guesses) == ("Hello there.",)
    assert guesses == ["Hello", "Hello there."]
    (asked,) = server.asked
    with wave.open(io.BytesIO(asked.pop("sound"))) as sent:
        assert (sent.getnchannels(), sent.getsampwidth(), sent.getframerate()) == (1, 2, 16_000)
        assert np.array_equal(np.frombuffer(sent.readframes(1 << 20), "<i2"), SOUND)
    assert asked == {"model": "whisper-1", "response_format": "json", "language": "en", "stream": "true"}


async def test_a_server_without_partial_results_is_asked_without_them(server: SpeechServer) -> None:
    async def no_stream(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
        if "stream" in server.asked[-1]:
            return web.json_response({"error": {"message": "stream is not known"}}, status=400)
        return web.json_response({"text": "  Hello\nthere. "})

    server.behaviour = no_stream
    ears = ServerEars(EarsSettings(server.address, "whisper"))
    async with ears.open() as transcriber:
        for _ in range(2):
            await transcriber.begin(DICTATION)
            await transcriber.hear(SOUND)
            assert await transcriber.finish(lambda _: None) == ("Hello there.",)
    assert ["stream" in asked for asked in server.asked] == [True, False, False]
    server.behaviour = says(200, {"text": ""})
    assert await understood(server) == ()


async def test_only_sentences_of_the_grammar_are_told(server: SpeechServer) -> None:
    server.words = "Go to the window!"
    assert await understood(server, COMMANDS) == ("go to the window",)
    assert "language" not in server.asked[-1]
    server.words = "Go to the theatre."
    assert await understood(server, COMMANDS) == ()
    others = Expectation(("en",), f"{COMMANDS.grammar}public <all> = <command> | <other_speech>;<other_speech> = day;")
    assert await understood(server, replace(others, rule="all")) == (OTHER_SPEECH,)
    server.words = ""
    assert await understood(server, replace(others, rule="all")) == ()
    ears = ServerEars(EarsSettings(server.address))
    assert ears.refusal(COMMANDS) == ""
    assert "`default` or a text in JSGF" in ears.refusal(Expectation(("en",), "no grammar"))


async def test_a_very_long_utterance_is_cut(server: SpeechServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_UTTERANCE", 1)
    await understood(server)
    with wave.open(io.BytesIO(server.asked[0]["sound"])) as sent:
        assert sent.getnframes() == 16_000


async def half_an_event(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
    response = await begin(request, "text/event-stream")
    await response.write(event({"type": "transcript.text.delta", "delta": "Hel"}))
    return response


async def nonsense(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
    response = await begin(request, "text/event-stream")
    await response.write(b"data: {not json\n\n")
    return response


async def failing(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
    response = await begin(request, "text/event-stream")
    await response.write(event({"error": {"message": "overloaded"}}))
    return response


async def endless(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
    response = await begin(request, "text/event-stream")
    for _ in range(3000):
        await response.write(event({"type": "transcript.text.delta", "delta": "word " * 200}))
    return response


@pytest.mark.parametrize(
    ("behaviour", "said"),
    [
        (half_an_event, "the recognition server at ORIGIN ended its answer before the text was complete"),
        (nonsense, "the recognition server at ORIGIN answers with no JSON object"),
        (failing, "the recognition server at ORIGIN has failed in the middle of its answer"),
        (endless, "the recognition server at ORIGIN sent more than was asked for, and was cut off"),
        (says(200, "[1]"), "the recognition server at ORIGIN answers with no JSON object"),
        (says(200, "[" * 100_000), "the recognition server at ORIGIN answers with no JSON object"),
        (says(200, {"words": 1}), "the recognition server at ORIGIN answers without a text"),
        (says(200, "hello", "text/html"), "the recognition server at ORIGIN answers with text/html where JSON was"),
        (says(429, ""), "the recognition server at ORIGIN takes no more now (429); try again later"),
        (
            says(400, {"error": {"message": "too short"}}),
            "the recognition server at ORIGIN refuses this (400): too short",
        ),
    ],
)
async def test_an_answer_that_is_none_is_a_failure(server: SpeechServer, behaviour: Behaviour, said: str) -> None:
    assert (await refused(server, behaviour)).startswith(said)


async def test_a_server_that_does_not_answer_is_given_up(server: SpeechServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service, "BEGIN_TIMEOUT", 0.3)
    assert await refused(server, silent) == "the recognition server at ORIGIN does not answer: nothing came for 0.3 s"


async def test_a_server_that_is_away_or_refuses_the_key_is_told_before_anything_is_sent(
    tmp_path: Path, unused_tcp_port: int
) -> None:
    key = tmp_path / "key"
    key.write_text("sk-wrong")
    async with asyncio.timeout(60), speech_server("sk-right") as server:
        said = f"the recognition server at ORIGIN refuses access (401): check the key in {key}"
        assert await refused(server, key_file=key) == said
        key.write_text("sk-right")
        assert await understood(server, key_file=key) == ("Hello there.",)
        assert len(server.asked) == 1
        server.address = ServiceAddress(f"http://127.0.0.1:{unused_tcp_port}/v1")
        assert await refused(server) == (
            "the recognition server at ORIGIN cannot be used: nothing listens there; check --ears-url"
        )


def test_without_an_address_it_says_which_option_it_wants() -> None:
    works, reason = ServerEars(EarsSettings()).available()
    assert (works, reason) == (False, "recognition by a server needs its address: --ears-url https://example.org/v1")


class TestConsent:
    """What is said before the microphone is sent to another machine with consent only."""

    QUIET = np.zeros((48_000, 2), np.int16)
    UTTERANCE = np.concatenate([QUIET[:14_400], stereo_48k(voice(0.8)), QUIET[:33_600]])

    class Room(Listened):
        def __init__(self, recognizer: SpeechRecognizer, consent: list[bool] | None) -> None:
            super().__init__()
            self.ear = Ear(self.microphone, self.clock)
            may_send = None if consent is None else lambda: consent[-1]
            self.recognition = Recognition(SpeechDetector(self.ear), recognizer, self.clock, may_send)
            self.told: list[tuple[str, ...]] = []
            self.guesses: list[str] = []
            self.failures: list[str] = []
            self.recognition.recognized.add(lambda candidates, _at, _sender: self.told.append(candidates))
            self.recognition.guessed.add(lambda guess, _sender: self.guesses.append(guess))
            self.recognition.failed.add(self.failures.append)

        def running(self) -> tuple[asyncio.Future[None], ...]:
            return asyncio.ensure_future(self.ear.run()), asyncio.ensure_future(self.recognition.run())

    def recognizer(self, destination: str) -> ScriptedRecognizer:
        recognizer = ScriptedRecognizer()
        recognizer.destination = destination
        return recognizer

    async def test_without_a_word_about_it_only_this_machine_gets_sound(self) -> None:
        for destination, heard in (("", 1), ("https://h.example", 0)):
            recognizer = self.recognizer(destination)
            room = self.Room(recognizer, None)
            async with room.plugged(*room.running()):
                room.recognition.want()
                await room.say(self.UTTERANCE)
                await room.say(self.UTTERANCE)
            assert len(room.told) == 2 * heard
            assert len(recognizer.heard) == 2 * heard
            # The reason is told once, not with each sentence.
            assert room.failures == [
                "the person who speaks has not agreed that the sound is sent to https://h.example"
            ] * (1 - heard)
            assert room.recognition.destination == destination
            assert room.recognition.withheld == ("" if heard else room.failures[0])
            assert room.recognition.failure == ""

    async def test_with_consent_it_is_sent_and_after_a_withdrawal_nothing_of_the_utterance_is(self) -> None:
        recognizer, consent = self.recognizer("https://h.example"), [True]
        room = self.Room(recognizer, consent)
        async with room.plugged(*room.running()):
            room.recognition.want()
            await room.say(self.UTTERANCE)
            assert room.told == [("hello", "hollow")]
            heard, guesses = len(recognizer.heard), len(room.guesses)
            half = len(self.UTTERANCE) // 3
            await room.say(self.UTTERANCE[:half])
            consent.append(False)
            await room.say(self.UTTERANCE[half : half + 480])
            known = recognizer._samples
            await room.say(self.UTTERANCE[half + 480 :])
            assert (len(recognizer.heard), recognizer._samples) == (heard, known)
            assert room.told == [("hello", "hollow")]
            assert len(room.guesses) - guesses <= half // 4800
            # What was begun without consent is not sent, though consent comes in its middle.
            await room.say(self.UTTERANCE[:half])
            consent.append(True)
            await room.say(self.UTTERANCE[half:])
            assert len(room.told) == 1
            await room.say(self.UTTERANCE)
            assert len(room.told) == 2

    async def test_what_was_said_before_the_consent_is_not_sent_with_what_follows(self) -> None:
        recognizer, consent = self.recognizer("https://h.example"), [False]
        room = self.Room(recognizer, consent)
        began = asyncio.Event()
        async with room.plugged(*room.running()):
            room.recognition.want()
            room.recognition._speech.speech_began.add(lambda _at: began.set())
            for first in range(0, len(self.UTTERANCE), 480):
                await room.say(self.UTTERANCE[first : first + 480])
                if first == 14_400 + 2_400:
                    # 50 ms into the speech, which is not noticed yet.
                    assert not began.is_set()
                    consent.append(True)
        with_consent = len(self.UTTERANCE) - 14_400 - 2_400
        assert began.is_set()
        assert room.told == [("hello", "hollow")]
        assert 0 < recognizer.heard[0] <= with_consent / 3

    async def test_a_result_that_comes_after_the_withdrawal_is_not_told(self) -> None:
        recognizer, consent = self.recognizer("https://h.example"), [True]
        room = self.Room(recognizer, consent)
        async with room.plugged(*room.running()):
            room.recognition.want()
            await room.say(self.UTTERANCE[:-24_000])
            recognizer.held = asyncio.Event()
            await room.say(self.UTTERANCE[-24_000:])
            consent.append(False)
            recognizer.held.set()
            await room.say(self.QUIET[:480])
        assert room.told == []


async def test_the_component_says_what_is_wrong_while_the_server_is_away(unused_tcp_port: int) -> None:
    room = Listened()
    recognizer = ServerEars(EarsSettings(ServiceAddress(f"http://127.0.0.1:{unused_tcp_port}/v1")))
    senses = microphone_senses("avatar", room.microphone, room.clock, recognizer)
    component = next(each for each in senses.components if isinstance(each, SpeechRecognition))
    assert component.condition() is ComponentStatus.READY
    failed = asyncio.Event()
    senses.recognition.failed.add(lambda _reason: failed.set())
    running = asyncio.ensure_future(senses.run())
    async with asyncio.timeout(30), room.plugged(running):
        senses.recognition.want()
        await failed.wait()
        assert component.condition() is ComponentStatus.ERROR
        said = f"the recognition server at http://127.0.0.1:{unused_tcp_port} cannot be used: nothing listens there"
        assert component.problem() == f"{said}; check --ears-url"
        await room.say(np.zeros((4800, 2), np.int16))
        assert room.clock.now() > 1000.0


class TestServerAway:
    """A recogniser whose server goes: the condition says why, and the next utterance after its return is told."""

    async def test_the_reason_is_the_failure_until_the_server_is_back(self, server: SpeechServer) -> None:
        room = TestConsent.Room(ServerEars(EarsSettings(server.address)), None)
        failed, recognized = asyncio.Event(), asyncio.Event()
        room.recognition.failed.add(lambda _reason: failed.set())
        room.recognition.recognized.add(lambda _words, _at, _sender: recognized.set())

        async def until(so: asyncio.Event) -> None:
            """Let the time of the test pass while the server, which has its own, is waited for."""
            while not so.is_set():
                await room.clock.advance(0.5)
                await asyncio.wait({asyncio.ensure_future(so.wait())}, timeout=0.02)

        server.behaviour = says(500, {"error": {"message": "out of memory"}})
        async with room.plugged(*room.running()):
            room.recognition.want()
            await room.say(TestConsent.UTTERANCE)
            await until(failed)
            assert "has failed (500): out of memory" in room.failures[-1]
            server.behaviour = None
            await room.say(TestConsent.UTTERANCE)
            await until(recognized)
        assert room.told == [("Hello there.",)]
        assert room.recognition.failure == ""
