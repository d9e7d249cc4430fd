# ruff: noqa: RUF001 - unusual letters are meant
"""The real speech process, spoken to through its parent."""

import itertools
import re
from collections.abc import AsyncIterator, Iterable
from contextlib import suppress

import pytest
from openrois_body.messages import Viseme
from openrois_body.speech import synthesizer as module
from openrois_body.speech.contract import SpeechRefused, SpeechRequest
from openrois_body.speech.markup import MAX_TEXT
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech.visemes import CONSONANTS, VOWELS, Phoneme, VisemeStream, letters

from tests.support.packages import ROOT, packages

pytestmark = pytest.mark.engine

KANA = (
    "あいうえおかきくけこがぎぐげごさしすせそざじずぜぞたちつてとだぢづでどなにぬねのはひふへほばびぶべぼ"
    "ぱぴぷぺぽまみむめもやゆよらりるれろわをん"
)
ALPHABETS = {
    "en": "abcdefghijklmnopqrstuvwxyz",
    "en-us": "abcdefghijklmnopqrstuvwxyz",
    "de": "abcdefghijklmnopqrstuvwxyzäöüß",
    "es": "abcdefghijlmnopqrstuvxyzñáéíóúü",
    "fr": "abcdefghijlmnopqrstuvxyzéèêàâùûçîïô",
    "ja": KANA,
}


@pytest.fixture
async def synthesizer() -> AsyncIterator[Synthesizer]:
    async with Synthesizer() as synthesizer:
        yield synthesizer


@pytest.mark.parametrize("language", ALPHABETS)
async def test_no_phoneme_it_says_is_unmapped(
    synthesizer: Synthesizer, language: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: set[str] = set()

    class Listening(VisemeStream):
        def add(self, phonemes: Iterable[Phoneme]) -> list[Viseme]:
            said.update(phoneme.ipa for phoneme in phonemes)
            return []

    monkeypatch.setattr(module, "VisemeStream", Listening)
    first_letters = ALPHABETS[language]
    words = ["".join(pair) for pair in itertools.product(first_letters, first_letters[:30])]
    for first in range(0, len(words), 1000):
        await synthesizer.synthesize(" ".join(words[first : first + 1000]), language=language, rate=450)
    assert len(said) > 30
    unmapped = {ipa for ipa in said for letter in letters(ipa) if letter not in VOWELS and letter not in CONSONANTS}
    assert unmapped == set()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "   ",
        "\x00\x01\x02",
        "...",
        "?!" * 1000,
        "9" * MAX_TEXT,
        "a" * MAX_TEXT,
        "𝔘🙂 \u200b ﷺ",
        "\ud800",
        "[[" * 50,
        "\\" * 99,
    ],
)
async def test_no_text_kills_it(synthesizer: Synthesizer, text: str) -> None:
    await synthesizer.voices()
    process = synthesizer._process
    spoken = await synthesizer.synthesize(text)
    assert spoken.visemes[-1].shape == "sil"
    assert synthesizer._process is process


@pytest.mark.parametrize(
    "ssml",
    [
        "<break time='99999999s'/>",
        "<prosody rate='99999999' pitch='+99999%' volume='-99999dB' range='x'>loud</prosody>",
        "<prosody rate='slow'><voice gender='female' xml:lang='ja'><emphasis>a</emphasis></voice>b</prosody>",
        "<say-as interpret-as='characters' format='x'>abc</say-as>",
        "<sub alias='" + "a" * 100 + "'>b</sub>",
        "<audio src='/etc/passwd'/><audio src='|sh'>x</audio>",
        "<voice xml:lang='" + "x" * 100 + "'>a</voice>",
        "<p><s>" * 3 + "a" + "</s></p>" * 3,
        "<unknown>" * 7 + "a" + "</unknown>" * 7,
    ],
)
async def test_no_ssml_kills_it(synthesizer: Synthesizer, ssml: str) -> None:
    await synthesizer.voices()
    process = synthesizer._process
    with suppress(SpeechRefused):
        await synthesizer.synthesize(ssml, ssml=True)
    assert synthesizer._process is process


@pytest.mark.parametrize("ssml", ["<speak>", "<p>" * 9 + "</p>" * 9, "&x;", "x" * (MAX_TEXT + 1)])
async def test_ssml_that_is_none_is_refused(synthesizer: Synthesizer, ssml: str) -> None:
    with pytest.raises(SpeechRefused):
        await synthesizer.synthesize(ssml, ssml=True)


async def test_ssml_is_obeyed(synthesizer: Synthesizer) -> None:
    plain = await synthesizer.synthesize("one two", ssml=True)
    paused = await synthesizer.synthesize("one <break time='2s'/> two", ssml=True)
    assert paused.duration == pytest.approx(plain.duration + 2, abs=0.5)
    assert [word.text for word in paused.words] == ["one", "two"]


@pytest.mark.parametrize(
    ("text", "ssml", "spoken"),
    [
        ("It costs 1234 euros; 🙂 I don't know.", False, ["It", "costs", "1234", "euros", "I", "don't", "know"]),
        ("  Tom &amp; Jerry <sub alias='go home'>gh</sub> now", True, ["Tom", "Jerry", "gh", "now"]),
        ("<![CDATA[a <]]> na\u00efve &#x41;bc", True, ["a", "naïve", "&#x41;bc"]),
        ("こんにちは世界、私", False, ["こんにちは世界", "私"]),
    ],
)
async def test_reported_words_are_in_the_text(
    synthesizer: Synthesizer, text: str, ssml: bool, spoken: list[str]
) -> None:
    language = "ja" if text.startswith("こ") else "en"
    said = (await synthesizer.synthesize(text, language=language, ssml=ssml)).words
    assert [word.text for word in said] == spoken
    assert all(text[word.position :].startswith(word.text) for word in said)
    assert [word.offset_ms for word in said] == sorted({word.offset_ms for word in said})


async def test_marks_are_told_with_their_names(synthesizer: Synthesizer) -> None:
    said = await synthesizer.synthesize("one <mark name='here &amp; now'/> two<mark name='end'/>", ssml=True)
    assert [mark.name for mark in said.marks] == ["here & now", "end"]
    assert said.marks[0].offset_ms == pytest.approx(said.words[1].offset_ms, abs=100)
    assert said.words[1].offset_ms < said.marks[1].offset_ms <= said.duration * 1000


async def test_a_speech_comes_in_pieces_that_are_complete(synthesizer: Synthesizer) -> None:
    text = "The second sentence is long, and it costs $5; <mark name='here'/>I don't know why, but <break/> it goes on."
    async with synthesizer.speak(SpeechRequest(text, ssml=True)) as chunks:
        pieces = [chunk async for chunk in chunks]
    assert len(pieces) > 5
    assert 0.1 < len(pieces[0].samples) / 48_000 < 0.8
    sent = 0.0
    for piece in pieces[:-1]:
        told = [word.offset_ms for word in piece.words] + [mark.offset_ms for mark in piece.marks]
        told += [each.offset_ms for each in piece.visemes]
        # Never later than its sound, and none of a piece to come but of the filter's delay.
        assert all(sent <= offset_ms + 10 for offset_ms in told)
        sent += len(piece.samples) / 48
        assert all(offset_ms < sent + 15 for offset_ms in told)
    words = [word for piece in pieces for word in piece.words]
    said = ["The", "second", "sentence", "is", "long", "and", "it", "costs", "5", "I", "don't"]
    assert [word.text for word in words][: len(said)] == said
    assert all(text[word.position :].startswith(word.text) for word in words)
    visemes = [viseme for piece in pieces for viseme in piece.visemes]
    assert [each.offset_ms for each in visemes] == sorted(each.offset_ms for each in visemes)
    assert visemes[-1].shape == "sil"
    assert [mark.name for piece in pieces for mark in piece.marks] == ["here"]


async def test_leaving_a_speech_in_its_middle_leaves_the_next_one_alone(synthesizer: Synthesizer) -> None:
    async with synthesizer.speak(SpeechRequest("one two three. " * 200)) as chunks:
        assert len((await anext(chunks)).samples) > 0
    assert [word.text for word in (await synthesizer.synthesize("one two")).words] == ["one", "two"]


async def test_a_text_need_not_be_read_before_the_next_one_is_made(synthesizer: Synthesizer) -> None:
    async with synthesizer.speak(SpeechRequest("one two three. " * 200)) as chunks:
        first = await anext(chunks)
        assert [word.text for word in (await synthesizer.synthesize("four")).words] == ["four"]
        words = [*first.words, *[word async for chunk in chunks for word in chunk.words]]
    assert len(words) == 600


async def test_a_speech_without_end_is_refused(synthesizer: Synthesizer) -> None:
    pause = "<break time='280s'/>"
    assert (await synthesizer.synthesize(pause, ssml=True)).duration == pytest.approx(280, abs=1)
    with pytest.raises(SpeechRefused, match="longer than 600 seconds"):
        await synthesizer.synthesize(f"a {pause} b {pause} c {pause}", ssml=True)


def test_no_other_module_loads_the_library() -> None:
    loads = re.compile(r"^\s*(import|from)\s+espeakng_loader|CDLL\(espeak", re.MULTILINE)
    found = [
        path.name for folder in packages() for path in (ROOT / folder).rglob("*.py") if loads.search(path.read_text())
    ]
    assert found == ["espeak_child.py"]
