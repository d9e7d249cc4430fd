"""XML text as elements with their lines: no document type, no entities, and bounds on size and depth."""

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from openrois.profiles.xml.names import GML, ROIS, XML, XSI

__all__ = ["MAX_DEPTH", "MAX_SIZE", "Element", "MalformedProfile", "Name", "parse", "without_layout"]

MAX_SIZE: Final = 4 << 20
"""Bytes of one document."""

MAX_DEPTH: Final = 32
"""Elements within one another."""

# No namespace can have it, so that what stands before it is the namespace.
_SEPARATOR: Final = "\n"

_WHITE: Final = " \t\n\r"
_PREFIXES: Final = {ROIS: "rois:", GML: "gml:", XSI: "xsi:", XML: "xml:", "": ""}


class MalformedProfile(ValueError):
    """A document is no profile.

    Attributes:
        line: where, counted from 1.
    """

    def __init__(self, line: int, sentence: str) -> None:
        super().__init__(f"line {line}: {sentence}")
        self.line = line


@dataclass(frozen=True, slots=True)
class Name:
    """A name in a namespace; white space around the namespace is none of it."""

    namespace: str
    local: str

    def __str__(self) -> str:
        return _PREFIXES.get(self.namespace, f"{{{self.namespace}}}")[:80] + self.local[:80]


@dataclass(slots=True)
class Element:
    """An element.

    Attributes:
        name: its name.
        line: where it begins.
        attributes: their values by name.
        type: what its xsi:type names, if it has one.
        children: the elements in it.
        pieces: the text in it, as it came.
    """

    name: Name
    line: int
    attributes: dict[Name, str]
    type: Name | None = None
    children: "list[Element]" = field(default_factory=list)
    pieces: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """Its text without layout."""
        return without_layout("".join(self.pieces))

    def wrong(self, sentence: str) -> MalformedProfile:
        """Return what to raise when something is wrong with it."""
        return MalformedProfile(self.line, f"{self.name} {sentence}")


def without_layout(text: str) -> str:
    """Return a text without the white space at either end where that has a line break; else it belongs to the text."""
    begun = text.lstrip(_WHITE)
    if "\n" in text[: len(text) - len(begun)]:
        text = begun
    ended = text.rstrip(_WHITE)
    return ended if "\n" in text[len(ended) :] else text


def parse(document: str | bytes) -> Element:
    """Return the root element of a document.

    Raises:
        MalformedProfile: it is not well-formed, has a document type, or is too large or too deep.
    """
    data = document.encode("utf-8", "surrogatepass") if isinstance(document, str) else document
    if len(data) > MAX_SIZE:
        raise MalformedProfile(1, f"the document has more than {MAX_SIZE} bytes")
    # What is text already is UTF-8 here, whatever its declaration says.
    return _Builder("utf-8" if isinstance(document, str) else None).build(data)


class _Builder:
    """Handles the events of expat."""

    def __init__(self, encoding: str | None) -> None:
        self._parser = parser = expat.ParserCreate(encoding, _SEPARATOR)
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end_element
        parser.CharacterDataHandler = self._take_text
        parser.StartNamespaceDeclHandler = self._declare
        parser.EndNamespaceDeclHandler = self._end_namespace
        parser.StartDoctypeDeclHandler = self._refuse_doctype
        self._root: Element | None = None
        self._open: list[Element] = []
        self._namespaces: defaultdict[str, list[str]] = defaultdict(list)

    def build(self, data: bytes) -> Element:
        try:
            self._parser.Parse(data, True)
        except expat.ExpatError as error:
            raise MalformedProfile(error.lineno, f"this is no XML: {expat.ErrorString(error.code)}") from None
        except MalformedProfile:
            raise
        except (ValueError, LookupError) as error:
            # The document declares an encoding that is unknown, or not read here.
            raise self._wrong(str(error)) from None
        assert self._root is not None, "expat refuses a document without an element"
        return self._root

    def _wrong(self, sentence: str) -> MalformedProfile:
        return MalformedProfile(self._parser.CurrentLineNumber, sentence)

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        if len(self._open) >= MAX_DEPTH:
            raise self._wrong(f"elements may be nested {MAX_DEPTH} deep at most")
        named = {_name(each): value for each, value in attributes.items()}
        element = Element(_name(name), self._parser.CurrentLineNumber, named)
        if (kind := named.get(Name(XSI, "type"))) is not None:
            prefix, _, local = kind.strip().rpartition(":")
            declared = self._namespaces[prefix]
            element.type = Name(declared[-1] if declared else "", local)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end_element(self, _name: str) -> None:
        self._open.pop()

    def _take_text(self, text: str) -> None:
        self._open[-1].pieces.append(text)

    def _declare(self, prefix: str | None, namespace: str | None) -> None:
        self._namespaces[prefix or ""].append((namespace or "").strip())

    def _end_namespace(self, prefix: str | None) -> None:
        self._namespaces[prefix or ""].pop()

    def _refuse_doctype(self, *_arguments: object) -> None:
        raise self._wrong("a profile has no document type")


def _name(text: str) -> Name:
    namespace, _, local = text.rpartition(_SEPARATOR)
    return Name(namespace.strip(), local)
