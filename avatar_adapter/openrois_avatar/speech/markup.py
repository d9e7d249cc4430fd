"""What may be said to espeak: texts without control characters, and SSML rebuilt from the elements that are harmless.

espeak reads files that SSML names, obeys commands behind control characters, and keeps open elements on stacks of fixed
size. So SSML is parsed here and written anew: known elements with known attributes stay, of others only their text.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

MAX_TEXT: Final = 4_000
"""Longest text or SSML document, in characters."""
MAX_DEPTH: Final = 8
_ELEMENTS: Final[Mapping[str, tuple[str, ...]]] = {
    "speak": ("xml:lang",),
    "p": ("xml:lang",),
    "s": ("xml:lang",),
    "voice": ("xml:lang", "gender"),
    "prosody": ("rate", "pitch", "range", "volume"),
    "emphasis": ("level",),
    "break": ("time", "strength"),
    "say-as": ("interpret-as", "format"),
    "sub": ("alias",),
}
_CONTROL: Final = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\u0080-\u009f\ud800-\udfff\ufffe\uffff]")
_VALUE: Final = re.compile(r"[\w .,+%:'-]{1,100}")


class MarkupError(ValueError):
    """The text cannot be spoken; the message says why."""


def plain_text(text: str) -> str:
    """The text without control characters.

    Raises:
        MarkupError: it is too long.
    """
    if len(text) > MAX_TEXT:
        raise MarkupError(f"a text has at most {MAX_TEXT} characters")
    return _CONTROL.sub(" ", text)


def safe_ssml(document: str) -> str:
    """The document with nothing but harmless elements; a fragment gets a `speak` around it.

    Raises:
        MarkupError: it is too long, not well-formed, too deep, or declares a document type.
    """
    document = plain_text(document).strip()
    if not document.startswith(("<speak", "<?xml")):
        document = f"<speak>{document}</speak>"
    return _Rebuild().run(document)


class _Rebuild:
    def __init__(self) -> None:
        self._parts: list[str] = []
        self._depth = 0

    def run(self, document: str) -> str:
        parser = expat.ParserCreate(encoding="utf-8")
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._text
        parser.StartDoctypeDeclHandler = self._refuse
        try:
            parser.Parse(document.encode(), True)
        except expat.ExpatError as error:
            raise MarkupError(f"the SSML is not well-formed: {error}") from error
        return "".join(self._parts)

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise MarkupError(f"the SSML has more than {MAX_DEPTH} elements inside each other")
        allowed = _ELEMENTS.get(name)
        if allowed is not None:
            kept = (
                f" {key}={quoteattr(value)}" for key, value in attributes.items() if key in allowed and _fits(value)
            )
            self._parts.append(f"<{name}{''.join(kept)}>")

    def _end(self, name: str) -> None:
        self._depth -= 1
        if name in _ELEMENTS:
            self._parts.append(f"</{name}>")

    def _text(self, text: str) -> None:
        self._parts.append(escape(text))

    def _refuse(self, *_: object) -> None:
        raise MarkupError("the SSML declares a document type")


def _fits(value: str) -> bool:
    return _VALUE.fullmatch(value) is not None
