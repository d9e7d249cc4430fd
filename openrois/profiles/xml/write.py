"""Profiles as XML documents in the structure of the standard's schema."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from openrois.profiles.xml.names import (
    CODE_SPACES,
    EXTRA,
    GML,
    ID_CODE_SPACE,
    ROIS,
    TYPE_ID,
    URN_CODE_SPACE,
    XSI,
    engine_id_text,
    identifier_of,
    identifier_text,
    is_code_space,
    no_component,
    write_id,
)
from openrois.profiles.xml.parse import MAX_DEPTH, MAX_SIZE, without_layout
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
)

__all__ = ["component_xml", "engine_xml"]

_NAMESPACES: Final = {"xmlns:rois": ROIS, "xmlns:gml": GML, "xmlns:xsi": XSI}
_UNFIT: Final = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_IN_TEXT: Final = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", "\r": "&#13;"})
_IN_ATTRIBUTE: Final = _IN_TEXT | str.maketrans({'"': "&quot;", "\n": "&#10;", "\t": "&#9;"})
_TIMEOUT_LIMIT: Final = 10**20


@dataclass(frozen=True, slots=True)
class _Node:
    """An element with children, or with text."""

    name: str
    attributes: Mapping[str, str] = field(default_factory=dict)
    content: "tuple[_Node, ...] | str" = ()


def engine_xml(profile: HRIEngineProfile) -> str:
    """Return an engine's profile, sub-engines included, as the text of an XML document: RoIS's `get_profile`.

    Raises:
        ValueError: a text has what XML cannot carry, such as a control character, a reference or an engine id stands
            twice, which an XML id cannot, or the document would be too large or too deep to be read.
    """
    return _document(_engine("rois:HRIEngineProfile", profile), unique_ids=_ids(profile))


def component_xml(profile: HRIComponentProfile, component_ref: str = "") -> str:
    """Return a component's profile as the text of an XML document.

    Args:
        profile: what it understands.
        component_ref: the document's XML id, the one that stands in the engine's profile; empty for the profile of a
            type.

    Raises:
        ValueError: a text has what XML cannot carry, such as a control character, or the document would be too large
            to be read.
    """
    extra = {} if profile.function is None else {"function": profile.function.value}
    if profile.part is not None:
        extra["part"] = profile.part
    return _document(
        _Node(
            "rois:HRIComponentProfile",
            {"gml:id": write_id(component_ref) if component_ref else TYPE_ID},
            (
                *_identity(profile.identifier, identifier_text(profile.identifier), profile.name, extra),
                *(_Node("rois:SubComponentProfile", content=urn) for urn in profile.sub_component_profiles),
                *(_message(message) for message in profile.command_profiles),
                *(_message(message) for message in profile.query_profiles),
                *(_message(message) for message in profile.event_profiles),
                *_parameters("rois:ParameterProfile", profile.parameter_profiles),
            ),
        )
    )


def _engine(name: str, profile: HRIEngineProfile) -> _Node:
    engine_id = profile.identifier.code
    ids = tuple(write_id(ref) for ref in profile.own_refs()) or (no_component(engine_id),)
    return _Node(
        name,
        {"gml:id": engine_id_text(engine_id)},
        (
            *_identity(profile.identifier, engine_id, engine_id, {}),
            *(_engine("rois:SubProfile", below) for below in profile.sub_profiles),
            *(_Node("rois:HRIComponent", content=each) for each in ids),
            *_parameters("rois:ParameterProfile", profile.parameter_profiles),
        ),
    )


def _ids(profile: HRIEngineProfile) -> Iterator[tuple[str, str]]:
    """Yield what must stand once in a document: what it is, and its text."""
    yield from (("the engine id", engine_id) for engine_id in profile.engine_ids())
    yield from (("the component", ref) for ref in (*profile.component_refs(), *profile.repeated_refs()))


def _identity(identifier: RoISIdentifier, text: str, name: str, extra: Mapping[str, str]) -> Iterator[_Node]:
    """Yield the children that every GML object begins with.

    GML has a place for `text`, which stands for authority and code, and for its code space, which is the codebook if
    that is a URI. All else is one more gml:name each, and only where it does not follow from the text.
    """
    codebook, implied = identifier.codebook_ref, identifier_of(text)
    usual = URN_CODE_SPACE if text.startswith("urn:") else ID_CODE_SPACE
    said = is_code_space(codebook) and codebook not in CODE_SPACES
    yield _Node("gml:identifier", {"codeSpace": codebook if said else usual}, text)
    yield _Node("gml:name", content=name)
    if (identifier.code, identifier.authority) != (implied.code, implied.authority):
        extra = {**extra, "authority": identifier.authority}
    if codebook and not said:
        extra = {**extra, "codebook_ref": codebook}
    if identifier.version:
        extra = {**extra, "version": identifier.version}
    for key, text in extra.items():
        yield _Node("gml:name", {"codeSpace": f"{EXTRA}{key}"}, text)


def _message(profile: CommandMessageProfile | QueryMessageProfile | EventMessageProfile) -> _Node:
    attributes = {"xsi:type": f"rois:{type(profile).__name__}Type", "rois:name": profile.name}
    content = _parameters("rois:Results", profile.results)
    if isinstance(profile, CommandMessageProfile):
        content += _parameters("rois:Arguments", profile.arguments)
        if profile.timeout is not None:
            if abs(profile.timeout) >= _TIMEOUT_LIMIT:
                raise ValueError(f"the timeout of the command {profile.name!r} has more than 20 digits")
            attributes["rois:timeout"] = str(profile.timeout)
    return _Node("rois:MessageProfile", attributes, content)


def _parameters(name: str, profiles: tuple[ParameterProfile, ...]) -> tuple[_Node, ...]:
    return tuple(
        _Node(
            name,
            {"rois:name": profile.name}
            | _given({"rois:default_value": profile.default_value, "rois:description": profile.description}),
            (_Node("rois:data_type_ref", _data_type(profile.data_type_ref)),),
        )
        for profile in profiles
    )


def _data_type(identifier: RoISIdentifier) -> dict[str, str]:
    return (
        _given({"rois:authority": identifier.authority})
        | {"rois:code": identifier.code}
        | _given({"rois:codebook_ref": identifier.codebook_ref, "rois:version": identifier.version})
    )


def _given(attributes: Mapping[str, str]) -> dict[str, str]:
    return {name: value for name, value in attributes.items() if value}


def _document(root: _Node, unique_ids: Iterable[tuple[str, str]] = ()) -> str:
    seen: set[tuple[str, str]] = set()
    for what, text in unique_ids:
        if not text:
            raise ValueError(f"{what} is empty, which an XML id cannot be")
        if (what, text) in seen:
            raise ValueError(f"{what} {text!r} stands twice, which an XML id cannot")
        seen.add((what, text))
    root = _Node(root.name, {**_NAMESPACES, **root.attributes}, root.content)
    text = '<?xml version="1.0" encoding="UTF-8"?>\n' + "".join(_lines(root, 1))
    if len(text.encode()) > MAX_SIZE:
        raise ValueError(f"the document would have more than {MAX_SIZE} bytes")
    return text


def _lines(node: _Node, depth: int) -> Iterator[str]:
    if depth > MAX_DEPTH:
        raise ValueError(f"elements may be nested {MAX_DEPTH} deep at most")
    indent = "  " * (depth - 1)
    attributes = "".join(
        f' {name}="{_escaped(node.name, value, _IN_ATTRIBUTE)}"' for name, value in node.attributes.items()
    )
    opening = f"{indent}<{node.name}{attributes}"
    if not node.content:
        yield f"{opening}/>\n"
    elif isinstance(node.content, str):
        yield f"{opening}>{_text(node.name, node.content)}</{node.name}>\n"
    else:
        yield f"{opening}>\n"
        for child in node.content:
            yield from _lines(child, depth + 1)
        yield f"{indent}</{node.name}>\n"


def _text(name: str, text: str) -> str:
    if without_layout(text) != text:
        raise ValueError(f"{name}: {text[:80]!r} begins or ends with a line break, which would be read as layout")
    return _escaped(name, text, _IN_TEXT)


def _escaped(name: str, text: str, table: Mapping[int, str]) -> str:
    if unfit := _UNFIT.search(text):
        raise ValueError(f"{name}: {text[:80]!r} has a character that XML cannot carry: U+{ord(unfit[0]):04X}")
    return text.translate(table)
