# ruff: noqa: RUF001 - the letters of IPA are meant
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.link.messages import command_from_json
from openrois_body.messages import VISEMES, Speak, Viseme
from openrois_body.speech.visemes import CONSONANTS, VOWELS, Phoneme, Shape, VisemeStream, letters, shapes, visemes

# What espeak-ng 1.52 says in these languages, collected from every phoneme of their tables and from all triples of
# their letters; stress marks are left out.
INVENTORY = {
    "en": "a aɪ aɪə aɪɚ aɪʊ aʊ aʊə b d dʒ eə eɪ eː f h i iə iː j k l m n oʊ oː p r s t tʃ uː v w z æ ð ŋ ɐ ɑː ɑːɹ ɑ̃ "
    "ɒ ɔ ɔɪ ɔː ɔːɹ ɔ̃ ə əl əɹ əʊ ɚ ɛ ɛɹ ɜː ɡ ɪ ɪɹ ɬ ɹ ɾ ʃ ʊ ʊə ʊɹ ʌ ʌɹ ʍ ʒ ʔ ʰa θ ᵻ",
    "de": "a aɪ aʊ b d dʒ eɪ eː f h i iɐ iː j k l m n oʊ oː p pf r s t ts tʃ uː v w x yː z ç ð øː ŋ œ œ̃ ɑ ɑː ɑ̃ ɒ ɔ ɔø "
    "ɔ̃ ə əl əʊ ɛ ɛɪ ɛː ɜ ɜː ɡ ɪ ɪː ɹ ɾ ʃ ʊ ʊɐ ʌ ʏ",
    "ja": "a b d dʑ dʒ e̞ h i iː j k l m n o̞ p r s t ts tɕ v w z ä ç ĩ ŋ ũ ɕ ə ɡ ɯᵝ ɴ ɸ ɽ ʔ",
    "es": "a aɪ aʊ b d dʒ e eɪ eʊ f i j k l m n o oɪ p r s t ts tʃ u w x ð ŋ ɛ ɟ ɡ ɣ ɲ ɾ ʃ ʋ ʎ ʝ β θ",
    "fr": "a a- aɪ aɪə aʊ b c d dʒ e e- eə eɪ f h i iə iː j k l m n o p s t tʃ u uː v w y y- z ð ø ŋ œ œ̃ ɐ ɑː ɑ̃ ɒ ɔ ɔɪ "
    "ɔː ɔ̃ ə ə- əl əʊ ɛ ɛ- ɛ̃ ɜː ɡ ɪ ɬ ɲ ɹ ʁ ʃ ʊ ʌ ʒ ʰcFʀ ʰl ʰr θ",
}


@pytest.mark.parametrize("language", INVENTORY)
def test_no_phoneme_of_our_languages_is_unmapped(language: str) -> None:
    for ipa in INVENTORY[language].split():
        assert shapes(ipa), ipa
        assert all(letter in VOWELS or letter in CONSONANTS for letter in letters(ipa)), ipa


def test_every_mouth_shape_is_used_and_no_other() -> None:
    used = {shape.name for table in (VOWELS, CONSONANTS) for shape in table.values()} | {"sil"}
    assert used == set(VISEMES)
    assert all(0 < shape.weight <= 1 for table in (VOWELS, CONSONANTS) for shape in table.values())


@pytest.mark.parametrize(
    ("ipa", "expected"),
    [
        ("p", [("PP", 1.0)]),
        ("ˈoʊ", [("oh", 1.0), ("ou", 1.0)]),
        ("oʊ", [("oh", 0.8), ("ou", 0.8)]),
        ("iː", [("ih", 1.0)]),
        ("aɪə", [("aa", 0.8), ("ih", 0.8), ("E", 0.48)]),
        ("ɑːɹ", [("aa", 1.0), ("RR", 1.0)]),
        ("tʃ", [("CH", 1.0)]),
        ("ts", [("SS", 1.0)]),
        ("pf", [("FF", 1.0)]),
        ("l̩", [("nn", 1.0)]),
        ("ĩ", [("ih", 0.8)]),
        ("i\u0303", [("ih", 0.8)]),
        ("ç", [("CH", 0.7)]),
        ("ɯᵝ", [("ou", 0.48)]),
        ("ʌ̃", [("aa", 0.8)]),
        ("A", [("aa", 0.8)]),
        ("é", [("E", 0.8)]),
        ("ж", [("E", 0.4)]),
        ("", []),
        ("ʲ", []),
        ("1", []),
        ("(de)", []),
    ],
)
def test_a_phoneme_has_the_shapes_of_its_sounds(ipa: str, expected: list[tuple[str, float]]) -> None:
    assert list(shapes(ipa)) == [Shape(*shape) for shape in expected]


def test_shapes_share_the_time_of_their_phoneme() -> None:
    phonemes = [Phoneme(10, "b"), Phoneme(60, "ˈaɪ"), Phoneme(160, "")]
    expected = (Viseme(10, "PP", 1), Viseme(60, "aa", 1), Viseme(110, "ih", 1), Viseme(160, "sil", 1))
    assert visemes(phonemes, 400) == expected


def test_the_mouth_closes_at_the_end() -> None:
    assert visemes([Phoneme(0, "m")], 80) == (Viseme(0, "PP", 1), Viseme(80, "sil", 1))
    assert visemes([], 0) == (Viseme(0, "sil", 1),)


def test_marks_without_a_sound_take_no_time() -> None:
    phonemes = [Phoneme(0, "ˈa"), Phoneme(50, "(de)"), Phoneme(60, "ʲ"), Phoneme(100, "t")]
    assert visemes(phonemes, 150) == (Viseme(0, "aa", 1), Viseme(100, "DD", 1), Viseme(150, "sil", 1))


def test_a_shape_that_follows_itself_is_said_once() -> None:
    phonemes = [Phoneme(0, "t"), Phoneme(50, "d"), Phoneme(100, ""), Phoneme(150, "")]
    assert visemes(phonemes, 200) == (Viseme(0, "DD", 1), Viseme(100, "sil", 1))


def test_phonemes_may_come_one_by_one() -> None:
    phonemes = [Phoneme(0, "ˈa"), Phoneme(50, "(de)"), Phoneme(100, "t"), Phoneme(150, "d"), Phoneme(200, "")]
    stream = VisemeStream()
    one_by_one = [stream.add([phoneme]) for phoneme in phonemes]
    assert one_by_one == [[], [], [Viseme(0, "aa", 1)], [Viseme(100, "DD", 1)], []]
    assert (*(each for some in one_by_one for each in some), *stream.finish(250)) == visemes(phonemes, 250)


@given(st.lists(st.tuples(st.floats(0, 1e6), st.text(max_size=8)), max_size=30), st.floats(0, 1e6))
@settings(max_examples=60, deadline=None)
def test_whatever_espeak_says_the_engine_accepts_it(sounds: list[tuple[float, str]], duration: float) -> None:
    phonemes = [Phoneme(offset, ipa) for offset, ipa in sorted(sounds) if offset <= duration]
    command = Speak("1", 0, visemes(phonemes, duration), 1)
    assert command_from_json(command.to_json()) == command
