"""Safe input for espeak: texts without control characters, and SSML rebuilt from harmless elements. Pure.

espeak reads files that SSML names, obeys commands behind control characters, and keeps open elements on stacks of fixed
size. So SSML is parsed here and written anew: known elements with known attributes stay, of others only their text.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Final
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

MAX_TEXT: Final = 4_000
"""Longest text or SSML document, in characters."""
MAX_SECONDS: Final = 600
"""Longest speech; SSML can ask for pauses without end, and a server can send sound without end."""
MAX_DEPTH: Final = 8
MAX_MARK: Final = 100
"""Characters of a mark's name that are kept."""
_ELEMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "speak": ("xml:lang",),
    "p": ("xml:lang",),
    "s": ("xml:lang",),
    "voice": ("xml:lang", "gender"),
    "prosody": ("rate", "pitch", "range", "volume"),
    "emphasis": ("level",),
    "break": ("time", "strength"),
    "say-as": ("interpret-as", "format"),
}
_APART: Final = frozenset({"p", "s", "break"})
"""Elements that keep words apart."""
_CONTROL: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\u0080-\u009f\ud800-\udfff\ufffe\uffff]")
_VALUE: Final = re.compile(r"[\w .,+%:'-]{1,100}")


class MarkupError(ValueError):
    """A text that cannot be spoken; the message says why."""


@dataclass(frozen=True, slots=True)
class Script:
    """The input of espeak, and its relation to the application's text.

    Attributes:
        spoken: plain text or SSML for espeak.
        source: the application's text, without control characters; of the same length.
        origins: for each character of `spoken`, the range of characters of `source` that it stands for.
        marks: the names of the marks in it; `spoken` has their numbers, from 0 on.
    """

    spoken: str
    source: str
    origins: Sequence[tuple[int, int]]
    marks: tuple[str, ...] = ()


def plain_text(text: str) -> Script:
    """Return the text without control characters.

    Raises:
        MarkupError: it is too long.
    """
    clean = _clean(text)
    return Script(clean, clean, _each(0, len(clean)))


def safe_ssml(document: str) -> Script:
    """Return the document with nothing but harmless elements; a fragment gets a `speak` around it.

    The alias of a `sub` stands there as text, since espeak reports wrong places behind a `sub`.

    Raises:
        MarkupError: it is too long, not well-formed, too deep, or declares a document type.
    """
    return _Rebuild(_clean(document)).run()


def spoken_text(text: str, *, ssml: bool) -> str:
    """Return what a voice that knows no markup says: one line, without control characters.

    Raises:
        MarkupError: as `plain_text` and `safe_ssml`.
    """
    parts: list[str] = []
    if ssml:
        parser = expat.ParserCreate(encoding="utf-8")
        parser.CharacterDataHandler = parts.append
        # A pause is a space.
        parser.StartElementHandler = lambda name, _: parts.append(" " if name in _APART else "")
        parser.EndElementHandler = lambda name: parts.append(" " if name in _APART else "")
        parser.Parse(safe_ssml(text).spoken.encode(), True)
    else:
        parts.append(plain_text(text).spoken)
    return " ".join("".join(parts).split())


def _clean(text: str) -> str:
    if len(text) > MAX_TEXT:
        raise MarkupError(f"the text has {len(text)} characters, and at most {MAX_TEXT} are allowed; split it")
    return _CONTROL.sub(" ", text)


def _each(first: int, count: int) -> list[tuple[int, int]]:
    """Return the origins of unchanged characters, from the character `first` on."""
    return [(place, place + 1) for place in range(first, first + count)]


class _Rebuild:
    def __init__(self, source: str) -> None:
        self._source = source
        stripped = source.strip()
        wrapped = not stripped.startswith(("<speak", "<?xml"))
        self._document = f"<speak>{stripped}</speak>" if wrapped else stripped
        self._moved = source.find(stripped) - len("<speak>") * wrapped
        # The parser counts bytes.
        begins = accumulate((len(character.encode()) for character in self._document), initial=0)
        self._places = {byte: place for place, byte in enumerate(begins)}
        self._parts: list[str] = []
        self._origins: list[tuple[int, int]] = []
        self._marks: list[str] = []
        self._depth = 0
        self._literal = False
        self._alias: str | None = None
        self._replaced: tuple[int, int] | None = None
        self._alias_depth = 0

    def run(self) -> Script:
        parser = self._parser = expat.ParserCreate(encoding="utf-8")
        parser.StartElementHandler = self._start_element
        parser.EndElementHandler = self._end_element
        parser.CharacterDataHandler = self._text
        parser.StartCdataSectionHandler = lambda: self._take_literally(True)
        parser.EndCdataSectionHandler = lambda: self._take_literally(False)
        parser.StartDoctypeDeclHandler = self._refuse
        try:
            parser.Parse(self._document.encode(), True)
        except expat.ExpatError as error:
            raise MarkupError(f"the SSML is not well-formed: {error}") from error
        return Script("".join(self._parts), self._source, self._origins, tuple(self._marks))

    def _put(self, text: str, first: int, last: int) -> None:
        """Write a text that stands for one part of the document."""
        self._parts.append(text)
        place = max(0, first + self._moved), max(0, last + self._moved)
        self._origins += [place] * len(text)

    def _put_tag(self, tag: str) -> None:
        here = self._here()
        self._put(tag, here, here)

    def _here(self) -> int:
        return self._places[self._parser.CurrentByteIndex]

    def _start_element(self, name: str, attributes: Mapping[str, str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise MarkupError(f"the SSML has elements nested more than {MAX_DEPTH} deep; use fewer")
        if self._alias is not None:
            return
        if name == "mark" and attributes.get("name"):
            self._put_tag(f'<mark name="{len(self._marks)}"/>')
            self._marks.append(attributes["name"][:MAX_MARK])
        elif name == "sub" and attributes.get("alias"):
            self._alias, self._alias_depth, self._replaced = attributes["alias"], self._depth, None
        elif name in _ELEMENTS:
            kept = (
                f" {key}={quoteattr(value)}"
                for key, value in attributes.items()
                if key in _ELEMENTS[name] and _fits(value)
            )
            self._put_tag(f"<{name}{''.join(kept)}>")

    def _end_element(self, name: str) -> None:
        depth, self._depth = self._depth, self._depth - 1
        if self._alias is None:
            if name in _ELEMENTS:
                self._put_tag(f"</{name}>")
        elif depth == self._alias_depth:
            here = self._here()
            self._put(escape(self._alias), *(self._replaced or (here, here)))
            self._alias = None

    def _text(self, text: str) -> None:
        first = self._here()
        is_reference = not self._literal and self._document.startswith("&", first)
        last = self._document.index(";", first) + 1 if is_reference else first + len(text)
        if self._alias is not None:
            self._replaced = (self._replaced or (first, last))[0], last
        elif is_reference:
            self._put(escape(text), first, last)
        else:
            for place, character in enumerate(text, first):
                self._put(escape(character), place, place + 1)

    def _take_literally(self, on: bool) -> None:
        self._literal = on

    def _refuse(self, *_: object) -> None:
        raise MarkupError("the SSML declares a document type, which is not allowed; remove it")


def _fits(value: str) -> bool:
    return _VALUE.fullmatch(value) is not None
