"""Rules of a component's profile, by itself and beside the standard's."""

import re
from collections.abc import Iterator
from typing import Final

from openrois.catalog.basic import BASIC_COMPONENTS
from openrois.catalog.common import ROIS_COMMON
from openrois.testing.subject import Subject, require
from openrois.types.profiles import HRIComponentProfile, ParameterProfile
from openrois.types.references import flaw_of_name, reference
from openrois.types.values import check_value

__all__ = [
    "it_has_an_identity",
    "it_has_the_commands_of_its_type",
    "its_profile_can_be_read",
    "its_profile_keeps_to_its_type",
]

_URN: Final = re.compile(r"urn:x-rois:def:[Cc]omponent:[^:\s]+::[^:\s]+")
_COMMON: Final = ROIS_COMMON.profile()
_TYPES: Final = {kind.urn: kind for kind in BASIC_COMPONENTS}
_STANDARD: Final = {urn: kind.profile() for urn, kind in _TYPES.items()}


async def it_has_an_identity(subject: Subject) -> None:
    """Its reference ends in its name, and its identifier has the authority and the code of a type."""
    name, component_type = subject.profile.name, subject.profile.component_type
    engine_id = subject.component_ref.partition("/")[0]
    require(not flaw_of_name(name), f"{name!r} cannot name a component: {flaw_of_name(name)}")
    due = reference(engine_id, name)
    require(subject.component_ref == due, f"its reference is {subject.component_ref!r}, its name asks for {due!r}")
    require(
        _URN.fullmatch(component_type) is not None,
        f"its type {component_type!r} is not formed like urn:x-rois:def:component:Example::Lamp: "
        "set the authority and the code of its identifier",
    )


async def its_profile_can_be_read(subject: Subject) -> None:
    """Names are there once and are names, defaults fit their types, and no text has what XML cannot carry."""
    profile = subject.profile
    for kind, names in _names(profile):
        require(len(names) == len(set(names)), f"its {kind} has a name twice: {', '.join(names)}")
        for name in names:
            require(bool(name) and name == name.strip(), f"{name!r} is no name ({kind})")
    for place, parameter in _parameters(profile):
        code = parameter.data_type_ref.code
        require(bool(code), f"{place}: {parameter.name} has no type")
        if parameter.default_value:
            try:
                check_value(code, parameter.default_value)
            except ValueError as error:
                require(False, f"{place}: the default of {parameter.name} does not fit: {error}")
    for text in _texts(profile.model_dump()):
        require(_xml_can_carry(text), f"{text!r} has a character that XML cannot carry")


async def its_profile_keeps_to_its_type(subject: Subject) -> None:
    """Messages and parameters that the standard has are as it has them; those of RoIS_Common come first."""
    profile = subject.profile
    for messages in (profile.command_profiles, profile.query_profiles):
        common = [_is_common(message.name) for message in messages]
        require(common == sorted(common, reverse=True), "messages of RoIS_Common do not come first")
    _require_same(profile, _COMMON, "RoIS_Common")
    standard = _STANDARD.get(profile.component_type)
    if standard is not None:
        _require_same(profile, standard, profile.component_type)
        if standard.function is not None:
            require(profile.function is standard.function, f"its class is {profile.function}, not {standard.function}")


async def it_has_the_commands_of_its_type(subject: Subject) -> None:
    """It has the commands that its type requires."""
    kind = _TYPES.get(subject.profile.component_type)
    required = () if kind is None else kind.required_commands()
    missing = [name for name in required if subject.profile.command(name) is None]
    others = ", ".join(each.name for each in subject.profile.command_profiles) or "none"
    require(not missing, f"{subject.profile.component_type} requires {', '.join(missing)}; its commands are {others}")


def _is_common(name: str) -> bool:
    return _COMMON.command(name) is not None or _COMMON.has_query(name)


def _require_same(profile: HRIComponentProfile, standard: HRIComponentProfile, whose: str) -> None:
    ours, theirs = dict(_values(profile)), dict(_values(standard))
    for place, values in ours.items():
        if place in theirs:
            require(values == theirs[place], f"{whose} has {place} with {theirs[place]}, the component with {values}")
    codes = {each.name: each.data_type_ref.code.lower() for each in standard.parameter_profiles}
    for parameter in profile.parameter_profiles:
        due = codes.get(parameter.name)
        found = parameter.data_type_ref.code.lower()
        require(due in (None, found), f"{whose} has the parameter {parameter.name} of type {due}, not {found}")


def _values(profile: HRIComponentProfile) -> Iterator[tuple[str, dict[str, str]]]:
    for command in profile.command_profiles:
        yield f"the arguments of {command.name}", _codes(command.arguments)
        yield f"the results of {command.name}", _codes(command.results)
    for query in profile.query_profiles:
        yield f"the results of query {query.name}", _codes(query.results)
    for event in profile.event_profiles:
        yield f"the results of event {event.name}", _codes(event.results)


def _codes(profiles: tuple[ParameterProfile, ...]) -> dict[str, str]:
    return {profile.name: profile.data_type_ref.code.lower() for profile in profiles}


def _names(profile: HRIComponentProfile) -> Iterator[tuple[str, list[str]]]:
    yield "commands", [message.name for message in profile.command_profiles]
    yield "queries", [message.name for message in profile.query_profiles]
    yield "events", [message.name for message in profile.event_profiles]
    yield "parameters", [parameter.name for parameter in profile.parameter_profiles]
    for place, values in _values(profile):
        yield place, list(values)


def _parameters(profile: HRIComponentProfile) -> Iterator[tuple[str, ParameterProfile]]:
    for parameter in profile.parameter_profiles:
        yield "parameters", parameter
    for command in profile.command_profiles:
        for parameter in (*command.arguments, *command.results):
            yield command.name, parameter
    for name, results in (
        *((query.name, query.results) for query in profile.query_profiles),
        *((event.name, event.results) for event in profile.event_profiles),
    ):
        for parameter in results:
            yield name, parameter


def _texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from _texts(item)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _texts(item)


def _xml_can_carry(text: str) -> bool:
    return all(
        character in "\t\n\r"
        or " " <= character <= "\ud7ff"
        or "\ue000" <= character <= "\ufffd"
        or character > "\uffff"
        for character in text
    )
