"""Which words of a text are spoken when, from what espeak tells of its own reading of it; pure.

espeak tells the place of each word that it reads, in the text that it was given. What it reads is not always a word of
the text: numbers become several words, and so do signs (`$` is "dollar"); words that it says in one breath are one
(`I am`), and a few places are one character too early (` don't`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import Final, NamedTuple

_APOSTROPHES: Final = re.compile(r"\w+(?:['’]\w+)+")  # noqa: RUF001 - both are written


class Place(NamedTuple):
    """A word, `length` characters from character `start` of a text on, and the moment from which on it is spoken."""

    offset_ms: float
    start: int
    length: int


def words(told: Iterable[Place], text: str, origins: Sequence[tuple[int, int]]) -> list[Place]:
    """The words of an application's text, in its order and in that of time; none of them twice.

    Args:
        told: what espeak tells of the text that it was given, in order of time.
        text: that text.
        origins: for each of its characters, from which character to which it stands for the application's text.
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
    """When, from where and to where in the text that espeak was given."""
    contracted = {place: match.span() for match in _APOSTROPHES.finditer(text) for place in range(*match.span())}
    exact = {place.start for place in told}
    for offset_ms, start, length in told:
        first, last = _trimmed(text, start, start + length)
        if first == last:
            # A sign or a space; the word right behind it is meant, unless that is told by itself.
            if last in exact or not text[last : last + 1].isalnum():
                continue
            last = first + 1
        yield offset_ms, *contracted.get(first, (first, last))


def _trimmed(text: str, first: int, last: int) -> tuple[int, int]:
    """From `first` to `last`, without what is no letter or figure at the ends; empty at its end if nothing is left."""
    first = max(0, first)
    last = max(first, min(len(text), last))
    while first < last and not text[first].isalnum():
        first += 1
    while last > first and not text[last - 1].isalnum():
        last -= 1
    return first, last
