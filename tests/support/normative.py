"""The catalog against the standard's own files, where their folder is given: the repository carries none."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from lxml import etree

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.catalog.component_type import ComponentType
from openrois.profiles.xml.read import ComponentDocument, read_profile
from openrois.types.profiles import HRIComponentProfile, ParameterProfile

__all__ = ["differences", "schema"]

_NO_PLACE = "an argument there, for which the schema has no place"
KNOWN = {
    "RoISCommon: name": "no instance is ever called by it",
    "SpeechRecognition: parameter languages: default": "theirs is no array, and not a code of ISO 639-1",
    "AudioStreaming: event notify_stream_status: result stream_id": _NO_PLACE,
    "VideoStreaming: event notify_stream_status: result stream_id": _NO_PLACE,
}
"""Where we differ and know why."""


def differences(directory: Path) -> list[str]:
    """Return how the catalog differs from the component profiles in a directory: `place: ours, theirs`."""
    found: list[str] = []
    for kind in (*BASIC_COMPONENTS, ROIS_COMMON):
        files = sorted(directory.rglob(f"{kind.code}.xml"))
        if not files:
            found.append(f"{kind.code}: there is no {kind.code}.xml")
        for file in files:
            document = read_profile(file.read_bytes())
            assert isinstance(document, ComponentDocument), file
            ours, theirs = facts(kind.definition(), kind), facts(document.profile, kind)
            found += [
                f"{place}: {ours.get(place, 'nothing')!r} here, {theirs.get(place, 'nothing')!r} there"
                for place in {**ours, **theirs}
                if ours.get(place) != theirs.get(place) and not any(place.startswith(known) for known in KNOWN)
            ]
    return found


def facts(profile: HRIComponentProfile, kind: ComponentType) -> dict[str, str]:
    """Return what a profile says, by place."""
    return {f"{kind.code}: {place}": fact for place, fact in _facts(profile)}


def _facts(profile: HRIComponentProfile) -> Iterator[tuple[str, str]]:
    yield "identifier", profile.identifier.code
    yield "name", profile.name
    yield "includes", " ".join(each.strip() for each in profile.sub_component_profiles)
    for command in profile.command_profiles:
        yield from _message(f"command {command.name}", command.results, command.arguments)
    for query in profile.query_profiles:
        yield from _message(f"query {query.name}", query.results)
    for event in profile.event_profiles:
        yield from _message(f"event {event.name}", event.results)
    yield from _values("parameter", profile.parameter_profiles)


def _message(
    place: str, results: Iterable[ParameterProfile], arguments: Iterable[ParameterProfile] = ()
) -> Iterator[tuple[str, str]]:
    yield place, "there"
    yield from _values(f"{place}: result", results)
    yield from _values(f"{place}: argument", arguments)


def _values(place: str, values: Iterable[ParameterProfile]) -> Iterator[tuple[str, str]]:
    for value in values:
        yield f"{place} {value.name}: type", value.data_type_ref.code
        yield f"{place} {value.name}: default", value.default_value


def schema(directory: Path) -> etree.XMLSchema | None:
    """Return the standard's schema from a directory; None where it, or GML which it imports, cannot be loaded."""
    files = sorted(directory.rglob("XML-Profiles.xsd"))
    try:
        return etree.XMLSchema(etree.parse(files[0], etree.XMLParser(no_network=True))) if files else None
    except (etree.XMLSchemaParseError, etree.XMLSyntaxError):
        return None
