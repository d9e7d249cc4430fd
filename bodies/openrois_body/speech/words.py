"""The times of the words of a text, from espeak's report on its reading. Pure.

espeak reports the place of each word that it reads, in its input. Such a word is not always a word of the text: numbers
become several words, and so do signs (`$` is "dollar"); words that it says in one breath are one (`I am`), and a few
places are one character too early (` don't`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from math import inf
from typing import Final, NamedTuple

_APOSTROPHES: Final = re.compile(r"\w+(?:['’]\w+)+")  # noqa: RUF001 - both are written


class Place(NamedTuple):
    """A word, `length` characters from character `start` of a text on, and the moment when it begins."""

    offset_ms: float
    start: int
    length: int


class WordFinder:
    """Finds the words of an application's text in espeak's report: in order of time, and none of them twice.

    A word is found when the next one was reported, or the report has ended.

    Args:
        text: espeak's input.
        origins: for each of its characters, the range of the application's text that it stands for.
    """

    def __init__(self, text: str, origins: Sequence[tuple[int, int]]) -> None:
        self._text = text
        self._origins = origins
        self._contracted = {
            place: match.span() for match in _APOSTROPHES.finditer(text) for place in range(*match.span())
        }
        self._until = 0
        self._reported: Place | None = None

    @property
    def pending_ms(self) -> float:
        """The moment before which all words are found."""
        return inf if self._reported is None else self._reported.offset_ms

    def add(self, reported: Iterable[Place]) -> list[Place]:
        """Return the words that are found with the next part of the report."""
        found: list[Place] = []
        for place in reported:
            found += self._find(place.start)
            self._reported = place
        return found

    def find_last(self) -> list[Place]:
        """Return the last word, if there is one: the report has ended."""
        return self._find(None)

    def _find(self, following: int | None) -> list[Place]:
        """Return the word that was reported last, where the next one that was begins at `following`."""
        place, self._reported = self._reported, None
        span = None if place is None else self._span(place, following)
        if place is None or span is None:
            return []
        start, end = self._origins[span[0]][0], self._origins[span[1] - 1][1]
        if start < self._until or end <= start:
            return []
        self._until = end
        return [Place(place.offset_ms, start, end - start)]

    def _span(self, place: Place, following: int | None) -> tuple[int, int] | None:
        """Return the first and last character of a reported word in espeak's input; None if there is none."""
        first, last = _trimmed(self._text, place.start, place.start + place.length)
        if first == last:
            # A sign or a space; the word right behind it is meant, unless that is reported by itself.
            if last in (place.start, following) or not self._text[last : last + 1].isalnum():
                return None
            last = first + 1
        return self._contracted.get(first, (first, last))


def _trimmed(text: str, first: int, last: int) -> tuple[int, int]:
    """Return the range without other characters than letters and digits at its ends; empty if nothing is left."""
    first = max(0, first)
    last = max(first, min(len(text), last))
    while first < last and not text[first].isalnum():
        first += 1
    while last > first and not text[last - 1].isalnum():
        last -= 1
    return first, last
