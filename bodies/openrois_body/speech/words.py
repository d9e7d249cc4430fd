"""The times of the words of a text, from espeak's report on its reading. Pure.

espeak reports the place of each word that it reads, in its input. Such a word is not always a word of the text: numbers
become several words, and so do signs (`$` is "dollar"); words that it says in one breath are one (`I am`), and a few
places are one character too early (` don't`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple

_APOSTROPHES: Final = re.compile(r"\w+(?:['’]\w+)+")  # noqa: RUF001 - both are written


class Place(NamedTuple):
    """A word, `length` characters from character `start` of a text on, and the moment when it begins."""

    offset_ms: float
    start: int
    length: int


def words(told: Iterable[Place], text: str, origins: Sequence[tuple[int, int]]) -> list[Place]:
    """Return the words of an application's text, in its order and in order of time; none of them twice.

    Args:
        told: espeak's report on its input, in order of time.
        text: espeak's input.
        origins: for each of its characters, the range of the application's text that it stands for.
    """
    found: list[Place] = []
    until = 0
    for offset_ms, first, last in _spans(tuple(told), text):
        start, end = origins[first][0], origins[last - 1][1]
        if start >= until and end > start:
            found.append(Place(offset_ms, start, end - start))
            until = end
    return found


def _spans(told: Sequence[Place], text: str) -> Iterator[tuple[float, int, int]]:
    """Return the time, first and last character of each word in espeak's input."""
    contracted = {place: match.span() for match in _APOSTROPHES.finditer(text) for place in range(*match.span())}
    exact = {place.start for place in told}
    for offset_ms, start, length in told:
        first, last = _trimmed(text, start, start + length)
        if first == last:
            # A sign or a space; the word right behind it is meant, unless that is reported by itself.
            if last in exact or not text[last : last + 1].isalnum():
                continue
            last = first + 1
        yield offset_ms, *contracted.get(first, (first, last))


def _trimmed(text: str, first: int, last: int) -> tuple[int, int]:
    """Return the range without other characters than letters and digits at its ends; empty if nothing is left."""
    first = max(0, first)
    last = max(first, min(len(text), last))
    while first < last and not text[first].isalnum():
        first += 1
    while last > first and not text[last - 1].isalnum():
        last -= 1
    return first, last
