# ruff: noqa: RUF001, RUF002 - the letters of IPA are meant
"""Conversion of phonemes in IPA to the fifteen mouth shapes. Pure.

A phoneme of espeak is a short string: stress and length marks, one vowel or consonant, or several glued together
(`ˈoʊ`, `tʃ`, `ɑːɹ`). It is read from the left: a cluster that is one movement of the mouth is taken whole, every other
letter is one shape, and the shapes share the time of the phoneme. So diphthongs become two shapes.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import Final, NamedTuple

from openrois_body.messages import Viseme

CLOSED: Final = "sil"
UNSTRESSED: Final = 0.8
"""Opening of the mouth for an unstressed vowel, as a share of that for a stressed one."""


class Phoneme(NamedTuple):
    """A phoneme from `offset_ms` on; an empty `ipa` is silence."""

    offset_ms: float
    ipa: str


class Shape(NamedTuple):
    """One of the fifteen mouth shapes and how strongly it shows, 0 to 1."""

    name: str
    weight: float


def _table(rows: Mapping[Shape, str]) -> dict[str, Shape]:
    return {letters: shape for shape, group in rows.items() for letters in group.split()}


VOWELS: Final = _table(
    {
        Shape("aa", 1.0): "a ɑ ä ɐ ʌ æ",
        Shape("E", 1.0): "e ɛ ε ɜ ɘ",
        Shape("E", 0.6): "ə ɚ",
        Shape("ih", 1.0): "i ɪ ɨ ᵻ",
        Shape("oh", 1.0): "o ɔ ɒ",
        Shape("oh", 0.7): "ø œ ɵ ɤ",
        Shape("ou", 1.0): "u ʊ ʉ",
        Shape("ou", 0.8): "y ʏ",
        Shape("ou", 0.6): "ɯ",
    }
)
"""Vowels by the opening and rounding of the lips."""

CONSONANTS: Final = _table(
    {
        Shape("PP", 1.0): "p b m",
        Shape("PP", 0.6): "β ɸ φ",
        Shape("FF", 1.0): "f v ɱ pf",
        Shape("FF", 0.7): "ʋ",
        Shape("TH", 1.0): "θ ð",
        Shape("DD", 1.0): "t d ʈ ɖ ɗ",
        Shape("kk", 1.0): "k g ɡ q ɢ c ɟ x χ ɣ ŋ ɴ",
        Shape("kk", 0.6): "ʁ ʀ",
        Shape("kk", 0.4): "h ħ ʔ ʕ",
        Shape("CH", 1.0): "ʃ ʒ ʂ ʐ ɕ ʑ tʃ dʒ tɕ dʑ tʂ dʐ",
        Shape("CH", 0.7): "ç",
        Shape("SS", 1.0): "s z ts dz ʦ",
        Shape("nn", 1.0): "n l ɲ ɳ ɫ ɬ ɭ ʎ",
        Shape("RR", 1.0): "r ɹ ɻ ɾ ɽ",
        Shape("ih", 0.7): "j ʝ",
        Shape("ou", 0.9): "w ʍ",
    }
)
"""Consonants, and clusters that are one movement, by where the mouth closes."""

_UNKNOWN: Final = Shape("E", 0.4)
_LONGEST: Final = 2
_STRESS: Final = frozenset("ˈˌː")


def letters(ipa: str) -> str:
    """Return the letters of a phoneme in lower case, without stress, length, tone and every other mark."""
    if ipa.startswith("("):
        return ""  # espeak marks a change of language so
    return "".join(letter for letter in map(_plain, unicodedata.normalize("NFC", ipa)) if letter)


@lru_cache(maxsize=1024)
def shapes(ipa: str) -> tuple[Shape, ...]:
    """Return the mouth shapes of one phoneme, in order; none for silence and for marks without a sound."""
    full = not _STRESS.isdisjoint(ipa)
    return tuple(_shapes(letters(ipa), full))


def is_sound(ipa: str) -> bool:
    """Return whether a phoneme takes time of its own: it is silence, or has a shape."""
    return not ipa or bool(shapes(ipa))


class VisemeStream:
    """Makes visemes of phonemes that come piece by piece: of each one when the next has come.

    Marks without a sound of their own, and repeated shapes, are left out.
    """

    def __init__(self) -> None:
        self._phoneme: Phoneme | None = None
        self._shape: Shape | None = None
        """The last one that was given."""

    def add(self, phonemes: Iterable[Phoneme]) -> list[Viseme]:
        """Return the visemes that are known with the next phonemes, in order of time."""
        found: list[Viseme] = []
        for phoneme in phonemes:
            if is_sound(phoneme.ipa):
                found += self._until(phoneme.offset_ms)
                self._phoneme = phoneme
        return found

    def finish(self, duration_ms: float) -> list[Viseme]:
        """Return the last ones; they end at `duration_ms`, with the mouth closed."""
        found = self._until(duration_ms)
        if self._shape is None or self._shape.name != CLOSED:
            found.append(Viseme(round(duration_ms, 1), CLOSED, 1.0))
        return found

    def _until(self, end_ms: float) -> list[Viseme]:
        phoneme, self._phoneme = self._phoneme, None
        found: list[Viseme] = []
        for viseme in () if phoneme is None else _spread(phoneme, end_ms):
            shape = Shape(viseme.shape, viseme.weight)
            if shape != self._shape:
                found.append(viseme)
                self._shape = shape
        return found


def visemes(phonemes: Iterable[Phoneme], duration_ms: float) -> tuple[Viseme, ...]:
    """Return the visemes of phonemes that are all known, as `VisemeStream` makes them."""
    stream = VisemeStream()
    return (*stream.add(phonemes), *stream.finish(duration_ms))


def _plain(letter: str) -> str:
    """Return the letter as the tables have it, empty for a mark."""
    if letter not in VOWELS and letter not in CONSONANTS:
        letter = unicodedata.normalize("NFD", letter.lower())[0]
    return letter if unicodedata.category(letter) in ("Ll", "Lo") else ""


def _shapes(rest: str, full: bool) -> Iterator[Shape]:
    while rest:
        size = next((size for size in range(_LONGEST, 0, -1) if rest[:size] in CONSONANTS), 1)
        found, rest = rest[:size], rest[size:]
        vowel = VOWELS.get(found)
        if vowel is None:
            yield CONSONANTS.get(found, _UNKNOWN)
        else:
            yield vowel if full else Shape(vowel.name, round(vowel.weight * UNSTRESSED, 2))


def _spread(phoneme: Phoneme, end_ms: float) -> Iterator[Viseme]:
    """Return the shapes of a phoneme, each with an equal share of its time."""
    parts = shapes(phoneme.ipa) or (Shape(CLOSED, 1.0),)
    share = max(0.0, end_ms - phoneme.offset_ms) / len(parts)
    for number, shape in enumerate(parts):
        yield Viseme(round(phoneme.offset_ms + number * share, 1), shape.name, shape.weight)
