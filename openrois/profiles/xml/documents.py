"""The documents of a whole system: one for its engine, and one for each of its components.

The engine's document names a component by the XML id that the component's own document has.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from openrois.profiles.xml.names import write_id
from openrois.profiles.xml.read import ComponentDocument, EngineDocument
from openrois.profiles.xml.write import component_xml, engine_xml
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    HRIEngineProfile,
    ParameterProfile,
    QueryMessageProfile,
)
from openrois.types.references import engine_of, flaw_of_name
from openrois.types.values import check_value

__all__ = ["Profiles", "assemble", "doubts", "write_documents"]

_ENGINE_DOCUMENT: Final = "engine.xml"
_MAX_NAME: Final = 200

_Message: TypeAlias = CommandMessageProfile | QueryMessageProfile | EventMessageProfile
_Described: TypeAlias = _Message | ParameterProfile


@dataclass(frozen=True, slots=True)
class Profiles:
    """The content of all documents of a system.

    Attributes:
        engine: the engine and all below it, if one of the documents is an engine's.
        components: the profiles of components by component_ref.
        types: the profiles of types, which are of no component in particular.
    """

    engine: HRIEngineProfile | None = None
    components: Mapping[str, HRIComponentProfile] = field(default_factory=dict)
    types: tuple[HRIComponentProfile, ...] = ()


def write_documents(engine: HRIEngineProfile, components: Mapping[str, HRIComponentProfile]) -> dict[str, str]:
    """Return the texts of a system's documents by their file names: `engine.xml` and `components/<id>.xml`.

    Raises:
        ValueError: a text has what XML cannot carry, or an id stands twice.
    """
    documents = {_ENGINE_DOCUMENT: engine_xml(engine)}
    for number, (component_ref, profile) in enumerate(components.items(), 1):
        xml_id = write_id(component_ref)
        name = xml_id if len(xml_id) <= _MAX_NAME else f"{xml_id[:_MAX_NAME]}-{number}"
        try:
            documents[f"components/{name}.xml"] = component_xml(profile, component_ref)
        except ValueError as error:
            raise ValueError(f"{component_ref!r}: {error}") from None
    return documents


def assemble(documents: Iterable[EngineDocument | ComponentDocument]) -> Profiles:
    """Put the documents of one system together.

    Raises:
        ValueError: there are two engines, two profiles of one component, or one of a component that the engine does
            not have.
    """
    engine: HRIEngineProfile | None = None
    components: dict[str, HRIComponentProfile] = {}
    types: list[HRIComponentProfile] = []
    for document in documents:
        if isinstance(document, EngineDocument):
            if engine is not None:
                raise ValueError(
                    f"there are two engines, {engine.identifier.code!r} and {document.profile.identifier.code!r}"
                )
            engine = document.profile
        elif not document.component_ref:
            types.append(document.profile)
        elif document.component_ref in components:
            raise ValueError(f"the component {document.component_ref!r} has two profiles")
        else:
            components[document.component_ref] = document.profile
    if engine is not None and (strange := components.keys() - set(engine.component_refs())):
        raise ValueError(f"the engine {engine.identifier.code!r} has no component {sorted(strange)[0]!r}")
    return Profiles(engine, components, tuple(types))


def doubts(profiles: Profiles) -> list[str]:
    """Return sentences about profiles that can be read but that a gateway would refuse, or that could not be used."""
    found = [] if profiles.engine is None else list(_of_engines(profiles.engine))
    refs = profiles.engine.component_refs() if profiles.engine is not None else ()
    missing = [ref for ref in refs if ref not in profiles.components]
    if missing and profiles.components:
        found.append(f"the component {missing[0]!r} has no profile" + _others(len(missing) - 1))
    for component in (*profiles.components.values(), *profiles.types):
        found += [f"{component.name}: {doubt}" for doubt in _of_component(component)]
    return found


def _others(count: int) -> str:
    return f", and {count} more have none" if count else ""


def _of_engines(engine: HRIEngineProfile) -> Iterator[str]:
    ids, refs = engine.engine_ids(), engine.component_refs()
    for engine_id in ids:
        if flaw := flaw_of_name(engine_id):
            yield f"{engine_id!r} is no engine id: {flaw}"
    yield from (f"the engine id {engine_id!r} stands twice" for engine_id in _repeated(ids))
    yield from (f"the component {ref!r} stands twice" for ref in engine.repeated_refs())
    for ref in dict.fromkeys(refs):
        if engine_of(ref) not in ids:
            yield f"the component {ref!r} does not begin with the id of an engine that offers it"


def _of_component(component: HRIComponentProfile) -> Iterator[str]:
    if not component.identifier.code:
        yield "its identifier is empty"
    for kind, whose, group in _groups(component):
        names = [each.name for each in group]
        if "" in names:
            yield f"{'an' if kind == 'argument' else 'a'} {kind}{whose} has no name"
        yield from (f"the {kind} {name!r}{whose} stands twice" for name in _repeated(names) if name)
    yield from _defaults(each for _, _, group in _groups(component) for each in group)


def _groups(component: HRIComponentProfile) -> Iterator[tuple[str, str, Sequence[_Described]]]:
    """Yield what is named within a component: the kind, the message if it is in one, and all names."""
    yield "command", "", component.command_profiles
    yield "query", "", component.query_profiles
    yield "event", "", component.event_profiles
    yield "parameter", "", component.parameter_profiles
    for command in component.command_profiles:
        yield "argument", f" of {command.name!r}", command.arguments
    messages: tuple[_Message, ...] = (
        *component.command_profiles,
        *component.query_profiles,
        *component.event_profiles,
    )
    for message in messages:
        yield "result", f" of {message.name!r}", message.results


def _repeated(names: Iterable[str]) -> list[str]:
    return [name for name, count in Counter(names).items() if count > 1]


def _defaults(described: Iterable[_Described]) -> Iterator[str]:
    for value in described:
        try:
            if isinstance(value, ParameterProfile) and value.default_value:
                check_value(value.data_type_ref.code, value.default_value)
        except ValueError as error:
            yield f"the default of {value.name!r}: {error}"
