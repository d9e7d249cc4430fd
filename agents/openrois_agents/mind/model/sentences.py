# ruff: noqa: RUF001 - the marks of several scripts are meant
"""Sentences of a text that arrives in pieces, each as soon as it is whole, in several languages. Pure."""

import re
from typing import Final

__all__ = ["MAX_SENTENCE", "Sentences"]

MAX_SENTENCE: Final = 240
"""Characters after which a text without an end is spoken up to its last pause."""

_LEAST_PART: Final = MAX_SENTENCE // 3

_ENDS_AT_ONCE: Final = "。！？｡…।॥۔؟։።"
"""What ends a sentence without a space behind it."""

_ENDS: Final = ".!?"
"""What ends a sentence where a space follows."""

_CLOSES: Final = "\"'“”‘’«»‹›)]}」』】）〉》"
"""What belongs to the sentence that stands before it."""

_PAUSES: Final = (",;:—–)、，；：،؛", " ")
"""Where a text that is too long is cut: behind the last of the first kind, else of the second."""

_BOUNDARY: Final = re.compile(
    rf"(?P<line>\n)|(?P<at_once>[{_ENDS_AT_ONCE}]+[{re.escape(_ENDS + _CLOSES + _ENDS_AT_ONCE)}]*)"
    rf"|(?P<mark>[{_ENDS}]+)(?P<closed>[{re.escape(_CLOSES)}]*)[*_]*(?=(?P<space>\s)|\Z)"
)

_BEFORE_NAMES: Final = frozenset(
    (
        *("mr", "mrs", "ms", "mx", "dr", "prof", "st", "sr", "sra", "srta", "mme", "mlle", "hr", "fr", "ing", "dipl"),
        *("gen", "col", "capt", "lt", "sgt", "rev", "no", "nr", "vs", "fig", "vol", "pp", "str", "bzw", "ca"),
        *("approx", "resp", "evtl", "inkl"),
    )
)
"""Abbreviations behind which a sentence goes on, whatever follows."""

_MAY_END: Final = frozenset(
    (
        *("etc", "usw", "jr", "inc", "ltd", "co", "corp", "al", "bros"),
        *("a.m", "p.m", "u.s", "u.k", "e.u", "z.b", "d.h", "u.a", "e.g", "i.e"),
    )
)
"""Abbreviations behind which a sentence ends where a capital letter follows."""

_WORD_BEFORE: Final = re.compile(r"[^\s(\[\"'“„«]+$")
_MARKUP: Final = re.compile(r"^\s*(?:#{1,6}|[-*•>])\s+|(?<!\w)[*_`~]+|[*_`~]+(?!\w)|[*`~]+")
_WORD: Final = re.compile(r"\w")


class Sentences:
    """Cuts a text into sentences while it arrives."""

    def __init__(self) -> None:
        self._rest = ""

    def add(self, text: str) -> list[str]:
        """Return the sentences that are whole with more text."""
        self._rest += text
        found: list[str] = []
        while True:
            end = self._end(has_paused=False)
            if end is None and len(self._rest) > MAX_SENTENCE:
                end = _pause(self._rest)
            if end is None:
                return found
            self._cut(end, found)

    def settle(self) -> list[str]:
        """Return the sentence that is whole if nothing belongs to its end any more, as nothing came for a moment."""
        found: list[str] = []
        if (end := self._end(has_paused=True)) is not None:
            self._cut(end, found)
        return found

    def finish(self) -> list[str]:
        """Return what is left: the text is over."""
        found: list[str] = []
        self._cut(len(self._rest), found)
        return found

    def _cut(self, end: int, found: list[str]) -> None:
        sentence, self._rest = _spoken(self._rest[:end]), self._rest[end:]
        if sentence:
            found.append(sentence)

    def _end(self, *, has_paused: bool) -> int | None:
        """Return where the first sentence ends, up to its bound; None where it goes on, or that is not known yet."""
        for found in _BOUNDARY.finditer(self._rest[:MAX_SENTENCE]):
            is_last = found.end() == len(self._rest)
            if found["mark"] is None:
                # Another mark or a quotation mark may follow, and belongs to it.
                is_end = found["line"] is not None or not is_last or has_paused
            elif found["space"] is None:
                # A digit or a letter may follow, as in 3.14.
                is_end = is_last and has_paused and self._is_end(found, following="")
            else:
                following = self._rest[found.end() :].lstrip()[:1]
                is_end = self._is_end(found, following=following or ("" if has_paused else "?"))
            if is_end:
                return found.end()
        return None

    def _is_end(self, found: re.Match[str], following: str) -> bool:
        """Tell whether marks end a sentence.

        Args:
            found: the marks, with quotation marks behind them.
            following: the next character that is no space; nothing where none comes, `?` where none came yet.
        """
        if found["closed"]:
            # "Stop!" he said.
            return following != "?" and not following.islower()
        return found["mark"] != "." or not self._abbreviates(found.start(), following)

    def _abbreviates(self, dot: int, following: str) -> bool:
        """Tell whether a single dot belongs to an abbreviation, a number or an initial."""
        before = self._rest[:dot]
        match = _WORD_BEFORE.search(before)
        word = "" if match is None else match[0].lower()
        if word in _BEFORE_NAMES:
            return True
        if word in _MAY_END:
            return not following.isupper()
        if word.isdigit():
            # The number of a list, or a German ordinal: a sentence begins with a capital letter.
            return len(word) <= 3 and (before.strip() == word or not following.isupper())
        return len(word) == 1 and word.isalpha() and word.isascii() and word != "i"


def _pause(text: str) -> int:
    """Return where a text that is too long is cut."""
    for marks in _PAUSES:
        if (at := max(text.rfind(mark, 0, MAX_SENTENCE) for mark in marks)) >= _LEAST_PART:
            return at + 1
    return MAX_SENTENCE


def _spoken(text: str) -> str:
    """Return a text without marks that are for the eye; nothing where there is no word in it."""
    plain = " ".join(_MARKUP.sub("", "".join(each if each.isprintable() else " " for each in text)).split())
    return plain if _WORD.search(plain) else ""
