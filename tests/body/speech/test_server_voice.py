"""The voice of a server, spoken to over HTTP on this machine."""

import asyncio
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import numpy as np
import pytest
from aiohttp import web
from numpy.typing import NDArray
from openrois_body.services import server as service
from openrois_body.services.address import ServiceAddress
from openrois_body.speech import server_voice as module
from openrois_body.speech.contract import (
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    VoiceSettings,
    collect_speech,
)
from openrois_body.speech.server_voice import AT_ONCE, ServerVoice
from openrois_body.speech.synthesizer import Synthesizer

from tests.support.certificates import Authority
from tests.support.http_answers import begin, silent
from tests.support.speech_server import (
    SOUND,
    Behaviour,
    SpeechServer,
    early_end,
    first_half,
    flood,
    odd_pieces,
    says,
    speech_server,
)

pytestmark = pytest.mark.engine

SENTENCE = "The first half of this sentence is heard before the second one is made."


@pytest.fixture
async def server() -> AsyncIterator[SpeechServer]:
    async with asyncio.timeout(60), speech_server() as server:
        yield server


@asynccontextmanager
async def voice_of(server: SpeechServer, **settings: object) -> AsyncIterator[ServerVoice]:
    async with ServerVoice(VoiceSettings(server.address, **settings)) as voice:  # type: ignore[arg-type]
        yield voice


async def spoken(voice: ServerVoice, text: str, volume: int = 100) -> NDArray[np.int16]:
    async with voice.speak(SpeechRequest(text, volume=volume)) as chunks:
        return (await collect_speech(chunks)).samples


async def refused(server: SpeechServer, behaviour: Behaviour, **settings: object) -> str:
    server.behaviour = behaviour
    async with voice_of(server, **settings) as voice:
        with pytest.raises((SpeechUnavailable, SpeechRefused)) as error:
            await spoken(voice, SENTENCE)
    return str(error.value).replace(server.address.origin, "ORIGIN")


def likeness(one: NDArray[np.int16], other: NDArray[np.int16]) -> float:
    """Correlation of two sounds of the same speech, which need not have the same level."""
    size = min(len(one), len(other))
    return float(np.corrcoef(one[:size], other[:size])[0, 1])


@pytest.mark.parametrize("behaviour", [None, odd_pieces])
async def test_what_the_server_says_is_what_is_heard(server: SpeechServer, behaviour: Behaviour | None) -> None:
    server.behaviour = behaviour
    said: list[NDArray[np.int16]] = []
    making = server.sound

    async def noted(text: str) -> NDArray[np.int16]:
        said.append(await making(text))
        return said[-1]

    server.sound = noted  # type: ignore[method-assign]
    async with voice_of(server) as voice:
        heard = await spoken(voice, SENTENCE)
    assert len(heard) == 2 * len(said[0])
    assert likeness(heard[::2], said[0]) > 0.99
    assert server.asked == [{"model": "tts-1", "voice": "alloy", "input": SENTENCE, "response_format": "pcm"}]


async def test_the_first_sound_is_there_while_the_server_withholds_the_rest(server: SpeechServer) -> None:
    server.behaviour = first_half
    async with voice_of(server) as voice, voice.speak(SpeechRequest(SENTENCE)) as chunks:
        heard: list[SpeechChunk] = [await anext(chunks)]
        while sum(len(chunk.samples) for chunk in heard) < 48_000:
            heard.append(await anext(chunks))
        assert np.abs(np.concatenate([chunk.samples for chunk in heard])).max() > 3000
        assert not server.go_on.is_set()
        server.go_on.set()
        rest = await collect_speech(chunks)
    assert rest.duration > 1


async def test_model_voice_key_and_text_are_sent_and_the_key_is_in_no_other_place(
    server: SpeechServer, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    key = tmp_path / "key"
    key.write_text("sk-secret\nsecond line\n")
    async with voice_of(server, model="speaks", names=("nova", "echo"), key_file=key) as voice:
        assert await voice.voices() == ("nova", "echo")
        assert await voice.languages() == ("mul",)
        marked_up = "<speak>Good <break/>day &amp; <sub alias='bye'>b</sub></speak>"
        request = SpeechRequest(marked_up, ssml=True, voice="echo")
        async with voice.speak(request) as chunks:
            await collect_speech(chunks)
        await spoken(voice, "one\ntwo")
        with pytest.raises(SpeechRefused, match=r"the voice 'alto' is not available; available_voices"):
            async with voice.speak(SpeechRequest("a", voice="alto")):
                pass
    assert [(each["model"], each["voice"], each["input"]) for each in server.asked] == [
        ("speaks", "echo", "Good day & bye"),
        ("speaks", "nova", "one two"),
    ]
    assert server.keys == ["Bearer sk-secret"] * 2
    assert "sk-secret" not in caplog.text
    assert "sk-secret" not in repr(voice.__dict__)


async def test_volume_is_obeyed_and_nothing_to_say_asks_nothing(server: SpeechServer) -> None:
    async with voice_of(server) as voice:
        loud, quiet = await spoken(voice, SENTENCE), await spoken(voice, SENTENCE, volume=25)
        assert np.abs(quiet).max() == pytest.approx(np.abs(loud).max() / 4, rel=0.1)
        assert len(await spoken(voice, "  \n ")) == 0
    assert len(server.asked) == 2


async def test_a_wav_file_of_another_rate_is_understood(server: SpeechServer) -> None:
    async def answer(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
        import io
        import wave

        file = io.BytesIO()
        with wave.open(file, "wb") as sound:
            sound.setnchannels(2)
            sound.setsampwidth(2)
            sound.setframerate(16_000)
            sound.writeframes(np.full(32_000, 1000, "<i2").tobytes())
        response = await begin(request, "audio/wav")
        await response.write(file.getvalue())
        return response

    server.behaviour = answer
    async with voice_of(server) as voice:
        heard = await spoken(voice, SENTENCE)
    assert len(heard) == 48_000
    assert np.abs(heard[1000:-1000] - 1000).max() <= 5


async def test_the_media_type_tells_the_rate(server: SpeechServer) -> None:
    async def answer(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
        response = await begin(request, "audio/pcm;rate=48000")
        await response.write(bytes(96_000))
        return response

    server.behaviour = answer
    async with voice_of(server) as voice:
        assert len(await spoken(voice, SENTENCE)) == 48_000


@pytest.mark.parametrize(
    ("status", "told", "expected"),
    [
        (
            400,
            {"error": {"message": "no such\nvoice"}},
            "the speech server at ORIGIN refuses this (400): no such voice",
        ),
        (422, {"detail": [{"loc": "model"}]}, "the speech server at ORIGIN refuses this (422), and does not say why"),
        (404, {"error": "?"}, "the speech server at ORIGIN has no audio/speech (404): ?; check --voice-url"),
        (429, {"error": {"message": "quota"}}, "the speech server at ORIGIN takes no more now (429): quota"),
        (429, "", "the speech server at ORIGIN takes no more now (429); try again later"),
        (500, "<html>", "the speech server at ORIGIN has failed (500)"),
        (302, "", "the speech server at ORIGIN sends requests elsewhere (302); check --voice-url"),
        (200, {"text": "?"}, "the speech server answers with application/json where samples (pcm) were asked for"),
    ],
)
async def test_a_refusal_is_told_in_a_sentence(server: SpeechServer, status: int, told: object, expected: str) -> None:
    assert await refused(server, says(status, told)) == expected


async def test_a_long_reason_is_cut(server: SpeechServer) -> None:
    assert len(await refused(server, says(400, {"error": {"message": "no " * 5000}}))) < 400


async def test_a_server_that_wants_a_key_says_where_it_belongs(tmp_path: Path) -> None:
    async with asyncio.timeout(60), speech_server("sk-right") as server:
        assert await refused(server, silent) == (
            "the speech server at ORIGIN refuses access (401): name the file of its key (--voice-key-file)"
        )
        file = tmp_path / "key"
        file.write_text("sk-wrong")
        said = await refused(server, silent, key_file=file)
        assert said == f"the speech server at ORIGIN refuses access (401): check the key in {file}"
        file.write_text("a key with spaces")
        assert await refused(server, silent, key_file=file) == (
            f"there is no key in {file}: its first line has to be the key"
        )
        missing = tmp_path / "none"
        assert "cannot be read from" in await refused(server, silent, key_file=missing)
        file.write_text("sk-right")
        server.behaviour = says(400, {"error": {"message": "what is sk-right?"}})
        async with voice_of(server, key_file=file) as voice:
            with pytest.raises(SpeechRefused, match=r"what is \(the key\)\?"):
                await spoken(voice, "a")


async def test_a_server_that_is_away_or_no_server_is_told(server: SpeechServer, unused_tcp_port: int) -> None:
    gone = SpeechServer(ServiceAddress(f"http://127.0.0.1:{unused_tcp_port}/v1"), server.synthesizer)
    assert await refused(gone, silent) == (
        "the speech server at ORIGIN cannot be used: nothing listens there; check --voice-url"
    )
    secure = SpeechServer(ServiceAddress(server.address.base.replace("http://", "https://")), server.synthesizer)
    assert "cannot be used: it does not speak TLS (" in await refused(secure, silent)


async def test_a_certificate_has_to_be_trusted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    authority = Authority(tmp_path)
    tls = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    tls.load_cert_chain(*authority.issue())
    async with asyncio.timeout(60), speech_server(tls=tls) as server:
        assert "cannot be used: its certificate is not trusted (" in await refused(server, silent)
        server.behaviour = None
        monkeypatch.setenv("SSL_CERT_FILE", str(authority.file))
        async with voice_of(server) as voice:
            assert len(await spoken(voice, SENTENCE)) > 48_000


async def test_a_server_that_is_silent_or_stops_in_the_middle_is_given_up(
    server: SpeechServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "BEGIN_TIMEOUT", 0.2)
    assert await refused(server, silent) == "the speech server at ORIGIN does not answer: nothing came for 0.2 s"
    monkeypatch.setattr(service, "BEGIN_TIMEOUT", 30.0)
    monkeypatch.setattr(service, "STALL_TIMEOUT", 0.2)
    assert await refused(server, first_half) == (
        "the speech server at ORIGIN has stopped in the middle of its answer: nothing came for 0.2 s"
    )


async def test_an_answer_that_ends_early_is_no_speech(server: SpeechServer) -> None:
    said = await refused(server, early_end)
    assert said.startswith("the speech server at ORIGIN cannot be used: it closed the connection before the end")


async def test_a_flood_is_cut_off(server: SpeechServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_SECONDS", 5)
    assert await refused(server, flood) == "the speech is longer than 5 seconds; split the text"
    await server.broken.wait()


async def test_an_answer_that_drips_is_given_up(server: SpeechServer, monkeypatch: pytest.MonkeyPatch) -> None:
    async def drip(_server: SpeechServer, request: web.Request) -> web.StreamResponse:
        response = await begin(request, SOUND)
        while not server.go_on.is_set():
            await response.write(bytes(2))
            with suppress(TimeoutError):
                await asyncio.wait_for(server.go_on.wait(), 0.02)
        return response

    monkeypatch.setattr(module, "MAX_SECONDS", 1)
    said = await refused(server, drip)
    assert said == "the speech server at ORIGIN took too long for its answer"


async def test_a_compressed_answer_is_refused(server: SpeechServer) -> None:
    async def squeeze(_server: SpeechServer, _request: web.Request) -> web.StreamResponse:
        response = web.Response(body=bytes(100_000), content_type="audio/pcm")
        response.enable_compression(web.ContentCoding.gzip)
        return response

    assert await refused(server, squeeze) == (
        "the speech server at ORIGIN answers compressed, which it was not asked for"
    )


async def test_what_is_not_read_is_not_taken_from_the_server(server: SpeechServer) -> None:
    server.behaviour = flood
    async with voice_of(server) as voice, voice.speak(SpeechRequest(SENTENCE)) as chunks:
        size = len((await anext(chunks)).samples)
        # The server stands still at full buffers: what it has written since is bounded.
        assert size < 48_000 * 4
        assert not server.broken.is_set()


async def test_of_many_texts_two_are_asked_for_at_a_time(server: SpeechServer) -> None:
    server.behaviour = first_half
    async with voice_of(server) as voice:
        waiting = [asyncio.ensure_future(spoken(voice, f"Text number {number}.")) for number in range(5)]
        for _ in range(AT_ONCE):
            await server.arrived.acquire()
        assert len(server.asked) == AT_ONCE
        server.go_on.set()
        assert all(len(sound) > 10_000 for sound in await asyncio.gather(*waiting))
    assert len(server.asked) == 5


async def test_leaving_in_the_middle_closes_the_connection(server: SpeechServer) -> None:
    server.behaviour = flood
    async with voice_of(server) as voice:
        async with voice.speak(SpeechRequest(SENTENCE)) as chunks:
            await anext(chunks)
        await server.broken.wait()


async def test_without_an_address_it_says_which_option_it_wants() -> None:
    async with ServerVoice(VoiceSettings()) as voice:
        works, reason = voice.available()
        assert (works, reason) == (
            False,
            "the voice of a server needs its address: --voice-url https://example.org/v1",
        )
        with pytest.raises(SpeechUnavailable, match="--voice-url"):
            async with voice.speak(SpeechRequest("a")):
                pass


def test_where_texts_go_is_told_unless_they_stay_here() -> None:
    assert ServerVoice(VoiceSettings(ServiceAddress("http://127.0.0.1:8000/v1"))).destination == ""
    assert ServerVoice(VoiceSettings(ServiceAddress("https://h.example/v1"))).destination == "https://h.example"
    assert Synthesizer().destination == ""
