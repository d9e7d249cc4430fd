"""The names of profile documents: namespaces, code spaces, and references of components and engines as XML ids."""

import re
from typing import Final

from openrois.types.profiles import RoISIdentifier, component_urn, type_identifier

__all__ = [
    "CODE_SPACES",
    "EXTRA",
    "GML",
    "ID_CODE_SPACE",
    "ROIS",
    "TYPE_ID",
    "URN_CODE_SPACE",
    "XML",
    "XSI",
    "engine_id_text",
    "identifier_of",
    "identifier_text",
    "is_code_space",
    "no_component",
    "read_id",
    "stands_for_no_component",
    "write_id",
]

ROIS: Final = "http://www.omg.org/spec/RoIS/20240801"
GML: Final = "http://www.opengis.net/gml/3.2"
XSI: Final = "http://www.w3.org/2001/XMLSchema-instance"
XML: Final = "http://www.w3.org/XML/1998/namespace"

URN_CODE_SPACE: Final = "urn:ietf:rfc:2141"
"""Of identifiers that are URNs, as in the standard's files."""

ID_CODE_SPACE: Final = "urn:x-openrois:id"
"""Of identifiers that are none, such as an engine's id."""

CODE_SPACES: Final = (URN_CODE_SPACE, ID_CODE_SPACE)
"""Code spaces that go without saying; any other is an identifier's `codebook_ref`."""

EXTRA: Final = "urn:x-openrois:profile:"
"""Leads the code space of each gml:name that carries what has no place else: `urn:x-openrois:profile:function`."""

TYPE_ID: Final = "component_profile"
"""The XML id of a profile that is of no component in particular, as in the standard's files."""

_ENGINE: Final = "engine."
_NOBODY: Final = "none."

_UNFIT: Final = re.compile(r"[^A-Za-z0-9_.-]|_(?=x[0-9A-F]{4}(?:[0-9A-F]{2})?_)|\A[^A-Za-z_]", re.ASCII)
_RESERVED: Final = re.compile(rf"\A(?:{re.escape(_ENGINE)}|{re.escape(_NOBODY)}|{TYPE_ID}\Z)")
_NUMBER: Final = re.compile(r"_x([0-9A-F]{4}|[0-9A-F]{6})_", re.ASCII)
_URI: Final = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:[A-Za-z0-9._~:/?@!$&'()*+,;=-]*(#[A-Za-z0-9._~-]*)?", re.ASCII)
_UNICODE: Final = 0x110000
_AUTHORITY: Final = re.compile(r"urn:x-rois:def:[A-Za-z]+:([^:]*)::", re.ASCII)


def write_id(reference: str) -> str:
    """Return a component reference as an XML id: `robot/arm` is `robot_x002F_arm`.

    What an id cannot have everywhere stands as the number of its code point, as SQL/XML (ISO 9075-14) writes names.
    """
    escaped = _UNFIT.sub(lambda match: _number(match[0]), reference)
    return _number(escaped[0]) + escaped[1:] if _RESERVED.match(escaped) else escaped


def read_id(text: str) -> str:
    """Return the component reference that an XML id stands for; without such numbers it is the same text."""
    return _NUMBER.sub(_character, text)


def engine_id_text(engine_id: str) -> str:
    """Return the XML id of an engine's profile; no component reference is written like it."""
    return _ENGINE + write_id(engine_id)


def no_component(engine_id: str) -> str:
    """Return the XML id that stands in an engine without components: the schema wants one at least."""
    return _NOBODY + write_id(engine_id)


def stands_for_no_component(text: str) -> bool:
    """Tell whether an XML id is one that `no_component` writes."""
    return text.startswith(_NOBODY)


def is_code_space(text: str) -> bool:
    """Tell whether `text` is a URI, as a code space has to be."""
    return _URI.fullmatch(text) is not None


def identifier_text(identifier: RoISIdentifier) -> str:
    """Return the gml:identifier of a component: the URN of its type, where authority and code form one."""
    urn = component_urn(identifier.code, identifier.authority)
    named = type_identifier(urn)
    is_formed = (named.code, named.authority) == (identifier.code, identifier.authority)
    return urn if is_formed and not identifier.code.startswith("urn:") else identifier.code


def identifier_of(text: str) -> RoISIdentifier:
    """Return the identifier that a gml:identifier means by itself, with the authority that a RoIS URN names."""
    named = type_identifier(text)
    if named.authority:
        return named
    found = _AUTHORITY.match(text)
    return RoISIdentifier(code=text, authority=found[1] if found else "")


def _number(character: str) -> str:
    code = ord(character)
    return f"_x{code:04X}_" if code < 0x10000 else f"_x{code:06X}_"


def _character(match: re.Match[str]) -> str:
    code = int(match[1], 16)
    return chr(code) if code < _UNICODE else match[0]
