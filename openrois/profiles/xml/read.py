"""Profile documents read: the structure of the standard's schema, checked element by element.

What the standard's own files do beside the schema is taken: white space around a namespace, and arguments of queries
and events, which have no place in the JSON form and are left out with a remark. So is an engine without components: the
schema wants one at least, which a gateway cannot give.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from openrois.profiles.xml.names import (
    CODE_SPACES,
    EXTRA,
    GML,
    ROIS,
    TYPE_ID,
    XML,
    XSI,
    identifier_of,
    read_id,
    stands_for_no_component,
)
from openrois.profiles.xml.parse import Element, Name, parse
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
)

__all__ = ["ComponentDocument", "EngineDocument", "read_profile"]


@dataclass(frozen=True, slots=True)
class EngineDocument:
    """The profile of an engine, and remarks on its document."""

    profile: HRIEngineProfile
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class ComponentDocument:
    """The profile of a component, and remarks on its document.

    Attributes:
        profile: what it understands.
        component_ref: whose profile it is, from the document's XML id; empty for that of a type.
        remarks: sentences about what is left out.
    """

    profile: HRIComponentProfile
    component_ref: str = ""
    remarks: tuple[str, ...] = ()


def read_profile(document: str | bytes) -> EngineDocument | ComponentDocument:
    """Read the profile of an engine or of a component.

    Raises:
        MalformedProfile: it is none; the message names line and element.
    """
    root = parse(document)
    remarks: list[str] = []
    if root.name == Name(ROIS, "HRIEngineProfile"):
        engine = _Engines(remarks).read(root)
        return EngineDocument(engine, tuple(remarks))
    if root.name == Name(ROIS, "HRIComponentProfile"):
        profile = _component(root, remarks)
        xml_id = _id(root)
        return ComponentDocument(profile, "" if xml_id == TYPE_ID else read_id(xml_id), tuple(remarks))
    raise root.wrong("is no profile: rois:HRIEngineProfile or rois:HRIComponentProfile is expected")


@dataclass(frozen=True, slots=True)
class _Child:
    """Which element may stand at some place, and how often."""

    name: Name
    least: int = 0
    most: int | None = None


def _rois(name: str, least: int = 0, most: int | None = None) -> _Child:
    return _Child(Name(ROIS, name), least, most)


def _gml(name: str, least: int = 0, most: int | None = None) -> _Child:
    return _Child(Name(GML, name), least, most)


_OBJECT: Final = (
    _gml("metaDataProperty"),
    _gml("description", 0, 1),
    _gml("descriptionReference", 0, 1),
    _gml("identifier", 1, 1),
    _gml("name"),
    _gml("remarks", 0, 1),
)
_ENGINE: Final = (*_OBJECT, _rois("SubProfile"), _rois("HRIComponent"), _rois("ParameterProfile"))
_COMPONENT: Final = (*_OBJECT, _rois("SubComponentProfile"), _rois("MessageProfile"), _rois("ParameterProfile"))
_MESSAGE: Final = (_rois("Results"), _rois("Arguments"))
_PARAMETER: Final = (_rois("data_type_ref", 1, 1),)
_FIELDS: Final = ("function", "part", "authority", "codebook_ref", "version")
_XML_ID: Final = re.compile(r"[^\W\d][\w.\-\u00B7]*")
_INTEGER: Final = re.compile(r"[+-]?[0-9]{1,20}", re.ASCII)


class _Engines:
    """Reads an engine and those below it; XML ids, engine ids and components stand once in a document."""

    def __init__(self, remarks: list[str]) -> None:
        self._remarks = remarks
        self._taken: set[tuple[str, str]] = set()

    def read(self, element: Element) -> HRIEngineProfile:
        _attributes(element, identified=True)
        self._require_new(element, "XML id", _id(element))
        children = _children(element, _ENGINE)
        identifier, _, extra = _identity(children, self._remarks)
        self._require_new(element, "engine id", identifier.code)
        for field in ("function", "part"):
            if field in extra:
                raise element.wrong(f"is an engine, which has no {field}")
        if not children["HRIComponent"]:
            self._remarks.append(f"line {element.line}: {element.name} has no rois:HRIComponent: the schema wants one")
        return HRIEngineProfile(
            identifier=identifier,
            sub_profiles=tuple(self.read(child) for child in children["SubProfile"]),
            component_ids=tuple(self._component_ids(children["HRIComponent"])),
            parameter_profiles=_parameters(children["ParameterProfile"]),
        )

    def _component_ids(self, elements: list[Element]) -> Iterator[str]:
        for element in elements:
            xml_id = _checked_id(element, _text(element))
            self._require_new(element, "XML id", xml_id)
            if not stands_for_no_component(xml_id):
                component_ref = read_id(xml_id)
                self._require_new(element, "component", component_ref)
                yield component_ref

    def _require_new(self, element: Element, what: str, text: str) -> None:
        if not text:
            raise element.wrong(f"has an empty {what}")
        if (what, text) in self._taken:
            raise element.wrong(f"has the {what} {text[:80]!r}, which stands twice")
        self._taken.add((what, text))


def _component(element: Element, remarks: list[str]) -> HRIComponentProfile:
    _attributes(element, identified=True)
    children = _children(element, _COMPONENT)
    identifier, name, extra = _identity(children, remarks)
    messages = [_message(child, remarks) for child in children["MessageProfile"]]
    return HRIComponentProfile(
        identifier=identifier,
        name=name,
        function=ComponentFunction(extra["function"]) if "function" in extra else None,
        part=extra.get("part"),
        sub_component_profiles=tuple(_text(child) for child in children["SubComponentProfile"]),
        command_profiles=tuple(each for each in messages if isinstance(each, CommandMessageProfile)),
        query_profiles=tuple(each for each in messages if isinstance(each, QueryMessageProfile)),
        event_profiles=tuple(each for each in messages if isinstance(each, EventMessageProfile)),
        parameter_profiles=_parameters(children["ParameterProfile"]),
    )


def _id(element: Element) -> str:
    xml_id = element.attributes.get(Name(GML, "id"))
    if xml_id is None:
        raise element.wrong("has no gml:id")
    return _checked_id(element, xml_id)


def _checked_id(element: Element, text: str) -> str:
    xml_id = text.strip()
    if not _XML_ID.fullmatch(xml_id):
        raise element.wrong(f"has {xml_id[:80]!r} where an XML id is expected")
    return xml_id


def _identity(
    children: Mapping[str, list[Element]], remarks: list[str]
) -> tuple[RoISIdentifier, str, Mapping[str, str]]:
    """Return the identifier, the name, and the fields that have names of their own."""
    (identifier,) = children["identifier"]
    if Name("", "codeSpace") not in identifier.attributes:
        raise identifier.wrong("has no codeSpace")
    code_space = _code_space(identifier)
    names: list[str] = []
    extra: dict[str, str] = {}
    for element in children["name"]:
        field = _code_space(element)
        if field.startswith(EXTRA):
            _take_extra(element, field.removeprefix(EXTRA), extra)
        elif names:
            remarks.append(f"line {element.line}: the name {_text(element)[:80]!r} is left out: there is another")
        else:
            names.append(_text(element))
    text = _text(identifier)
    implied = RoISIdentifier(code=text, authority=extra["authority"]) if "authority" in extra else identifier_of(text)
    codebook = "" if code_space in CODE_SPACES else code_space
    return (
        RoISIdentifier(
            code=implied.code,
            authority=implied.authority,
            codebook_ref=extra.get("codebook_ref", codebook),
            version=extra.get("version", ""),
        ),
        "".join(names),
        extra,
    )


def _code_space(element: Element) -> str:
    """Return an element's code space, a URI: white space around it means nothing (xsd:anyURI)."""
    return element.attributes.get(Name("", "codeSpace"), "").strip(" \t\r\n")


def _take_extra(element: Element, field: str, extra: dict[str, str]) -> None:
    text = _text(element)
    if field not in _FIELDS:
        raise element.wrong(f"is said to be {field[:80]!r}, which is none of {', '.join(_FIELDS)}")
    if field in extra:
        raise element.wrong(f"says the {field} a second time")
    if field == "function" and text not in set(ComponentFunction):
        raise element.wrong(f"says {text[:80]!r}, which is no function: {', '.join(ComponentFunction)}")
    extra[field] = text


def _message(element: Element, remarks: list[str]) -> CommandMessageProfile | QueryMessageProfile | EventMessageProfile:
    kind = element.type.local if element.type is not None and element.type.namespace == ROIS else ""
    children = _children(element, _MESSAGE)
    results, arguments = _parameters(children["Results"]), _parameters(children["Arguments"])
    if kind == "CommandMessageProfileType":
        attributes = _attributes(element, "name", optional=("timeout",))
        timeout = _timeout(element, attributes)
        return CommandMessageProfile(name=attributes["name"], results=results, arguments=arguments, timeout=timeout)
    name = _attributes(element, "name")["name"]
    if arguments:
        remarks.append(f"line {element.line}: the arguments of {name[:80]!r} are left out: only commands take some")
    if kind == "QueryMessageProfileType":
        return QueryMessageProfile(name=name, results=results)
    if kind == "EventMessageProfileType":
        return EventMessageProfile(name=name, results=results)
    raise element.wrong("does not say by its xsi:type whether it is a command, a query or an event")


def _timeout(element: Element, attributes: Mapping[str, str]) -> int | None:
    text = attributes.get("timeout")
    if text is None:
        return None
    if not _INTEGER.fullmatch(text.strip()):
        raise element.wrong(f"has the timeout {text[:80]!r}, which is no number of milliseconds")
    return int(text)


def _parameters(elements: list[Element]) -> tuple[ParameterProfile, ...]:
    return tuple(_parameter(element) for element in elements)


def _parameter(element: Element) -> ParameterProfile:
    attributes = _attributes(element, "name", optional=("default_value", "description"))
    (data_type,) = _children(element, _PARAMETER)["data_type_ref"]
    _children(data_type, ())
    identifier = _attributes(data_type, "code", optional=("authority", "codebook_ref", "version"))
    return ParameterProfile(data_type_ref=RoISIdentifier(**identifier), **attributes)


def _attributes(
    element: Element, required: str = "", *, optional: tuple[str, ...] = (), identified: bool = False
) -> dict[str, str]:
    """Return the rois: attributes of an element; those of xsi: and xml: are for validation and display."""
    found: dict[str, str] = {}
    for name, value in element.attributes.items():
        if name.namespace == ROIS and name.local in (required, *optional):
            found[name.local] = value
        elif name.namespace not in (XSI, XML) and not (identified and name == Name(GML, "id")):
            known = " and ".join(f"rois:{each}" for each in (required, *optional) if each) or "none here"
            raise element.wrong(f"has the attribute {name}, and can have {known}")
    if required and required not in found:
        raise element.wrong(f"has no rois:{required}")
    return found


def _children(element: Element, layout: tuple[_Child, ...]) -> dict[str, list[Element]]:
    """Return the children of an element by their local names, which no two of a layout share."""
    if "".join(element.pieces).strip():
        raise element.wrong(f"holds the text {element.text[:80]!r}, where elements are expected")
    found: dict[str, list[Element]] = {child.name.local: [] for child in layout}
    place = 0
    for child in element.children:
        later = (at for at in range(place, len(layout)) if layout[at].name == child.name)
        if (at := next(later, None)) is None:
            expected = ", ".join(str(each.name) for each in layout[place:]) or "nothing"
            raise child.wrong(f"cannot stand here in {element.name}; what can is {expected}")
        place = at
        found[child.name.local].append(child)
        most = layout[at].most
        if most is not None and len(found[child.name.local]) > most:
            raise child.wrong(f"stands a second time in {element.name}")
    for each in layout:
        if len(found[each.name.local]) < each.least:
            raise element.wrong(f"has no {each.name}")
    return found


def _text(element: Element) -> str:
    if element.children:
        raise element.children[0].wrong(f"cannot stand in {element.name}, which holds text")
    return element.text
