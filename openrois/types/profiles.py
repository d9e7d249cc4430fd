"""Profiles of engines and components: the JSON form of the types in the standard's XML schema (XML-Profiles.xsd)."""

import re
from collections import Counter
from typing import Final

from pydantic import Field

from openrois.types.codes import ComponentFunction
from openrois.types.model import Model

__all__ = [
    "CommandMessageProfile",
    "EventMessageProfile",
    "HRIComponentProfile",
    "HRIEngineProfile",
    "ParameterProfile",
    "QueryMessageProfile",
    "RoISIdentifier",
    "component_urn",
    "type_identifier",
]

_COMPONENT_URN: Final = re.compile(r"urn:x-rois:def:component:([^:]+)::(.+)", re.DOTALL)


class RoISIdentifier(Model):
    """An identifier (RoISIdentifierType): a code, and the authority and book that give it its meaning."""

    code: str
    authority: str = ""
    codebook_ref: str = ""
    version: str = ""


class ParameterProfile(Model):
    """The name and type of a parameter, an argument or a result."""

    name: str
    data_type_ref: RoISIdentifier
    default_value: str = ""
    description: str = ""


class CommandMessageProfile(Model):
    """A command: what it takes, what `get_command_result` gives, and the milliseconds it may take."""

    name: str
    results: tuple[ParameterProfile, ...] = Field(default=(), strict=False)
    arguments: tuple[ParameterProfile, ...] = Field(default=(), strict=False)
    timeout: int | None = None


class QueryMessageProfile(Model):
    """A query and its results; the schema gives queries no arguments."""

    name: str
    results: tuple[ParameterProfile, ...] = Field(default=(), strict=False)


class EventMessageProfile(Model):
    """An event and its results; the schema gives events no arguments."""

    name: str
    results: tuple[ParameterProfile, ...] = Field(default=(), strict=False)


class HRIComponentProfile(Model):
    """What one component understands. `name` is the instance's name; `function` and `part` are extensions of the wire.

    Attributes:
        part: of the body, such as `legs` or `voice`: its components have one holder, and change hands together.
    """

    identifier: RoISIdentifier
    name: str
    function: ComponentFunction | None = Field(default=None, strict=False)
    part: str | None = None
    sub_component_profiles: tuple[str, ...] = Field(default=(), strict=False)
    command_profiles: tuple[CommandMessageProfile, ...] = Field(default=(), strict=False)
    query_profiles: tuple[QueryMessageProfile, ...] = Field(default=(), strict=False)
    event_profiles: tuple[EventMessageProfile, ...] = Field(default=(), strict=False)
    parameter_profiles: tuple[ParameterProfile, ...] = Field(default=(), strict=False)

    @property
    def component_type(self) -> str:
        """The URN of the component's type, formed of authority and code unless the code is a URN itself."""
        code = self.identifier.code
        return code if code.startswith("urn:") else component_urn(code, self.identifier.authority)

    def command(self, name: str) -> CommandMessageProfile | None:
        """Return the command called `name`, or None."""
        return next((profile for profile in self.command_profiles if profile.name == name), None)

    def parameter(self, name: str) -> ParameterProfile | None:
        """Return the parameter called `name`, or None."""
        return next((profile for profile in self.parameter_profiles if profile.name == name), None)

    def has_query(self, name: str) -> bool:
        """Tell whether the component answers the query `name`."""
        return any(profile.name == name for profile in self.query_profiles)

    def has_event(self, name: str) -> bool:
        """Tell whether the component emits the event `name`."""
        return any(profile.name == name for profile in self.event_profiles)


class HRIEngineProfile(Model):
    """An engine, the components that are reachable through it, and its sub-engines, each with those it has of them."""

    identifier: RoISIdentifier
    sub_profiles: tuple["HRIEngineProfile", ...] = Field(default=(), strict=False)
    component_ids: tuple[str, ...] = Field(default=(), strict=False)
    parameter_profiles: tuple[ParameterProfile, ...] = Field(default=(), strict=False)

    def engine_ids(self) -> tuple[str, ...]:
        """Return the ids of this engine and of all below it, this one first."""
        below = tuple(engine_id for profile in self.sub_profiles for engine_id in profile.engine_ids())
        return (self.identifier.code, *below)

    def component_refs(self) -> tuple[str, ...]:
        """Return the refs of all components that are reachable through this engine, each once."""
        below = (ref for profile in self.sub_profiles for ref in profile.component_refs())
        return tuple(dict.fromkeys((*self.component_ids, *below)))

    def own_refs(self) -> tuple[str, ...]:
        """Return the refs of the components that no engine below this one lists."""
        below = {ref for profile in self.sub_profiles for ref in profile.component_refs()}
        return tuple(ref for ref in self.component_ids if ref not in below)

    def repeated_refs(self) -> tuple[str, ...]:
        """Return the refs that one engine lists twice, or two that do not stand below one another."""
        below = Counter(ref for profile in self.sub_profiles for ref in profile.component_refs())
        here = (ref for listed in (Counter(self.component_ids), below) for ref, times in listed.items() if times > 1)
        deeper = (ref for profile in self.sub_profiles for ref in profile.repeated_refs())
        return tuple(dict.fromkeys((*here, *deeper)))

    def completed(self) -> "HRIEngineProfile":
        """Return the profile with, at every level, all that is reachable through that engine."""
        below = tuple(profile.completed() for profile in self.sub_profiles)
        return self.model_copy(update={"sub_profiles": below, "component_ids": self.component_refs()})


def component_urn(code: str, authority: str = "OMG") -> str:
    """Return the component type's URN in the form of the standard's profiles."""
    return f"urn:x-rois:def:component:{authority}::{code}"


def type_identifier(urn: str) -> RoISIdentifier:
    """Return the identifier of the component type `urn`: authority and code apart, where it has that form."""
    found = _COMPONENT_URN.fullmatch(urn)
    return RoISIdentifier(code=urn) if found is None else RoISIdentifier(code=found[2], authority=found[1])
