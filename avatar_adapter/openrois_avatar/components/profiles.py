"""What the profiles of the avatar's components have in common."""

from openrois.component import COMMON_QUERIES
from openrois.types.codes import ComponentFunction
from openrois.types.profiles import (
    CommandMessageProfile,
    EventMessageProfile,
    HRIComponentProfile,
    ParameterProfile,
    QueryMessageProfile,
    RoISIdentifier,
    component_urn,
)

__all__ = ["component_profile"]


def component_profile(
    name: str,
    function: ComponentFunction,
    *,
    authority: str = "OMG",
    commands: tuple[CommandMessageProfile, ...] = (),
    queries: tuple[QueryMessageProfile, ...] = (),
    events: tuple[EventMessageProfile, ...] = (),
    parameters: tuple[ParameterProfile, ...] = (),
    common: bool = True,
) -> HRIComponentProfile:
    """Return a profile whose instance is called like its type.

    Args:
        name: the type's code, e.g. `Reaction`.
        function: its class; actuations have to be bound.
        authority: who defines the type.
        commands: its commands.
        queries: its queries beside those of RoIS_Common.
        events: its events.
        parameters: its parameters.
        common: whether it answers the queries of RoIS_Common; SystemInformation does not.
    """
    return HRIComponentProfile(
        identifier=RoISIdentifier(code=component_urn(name, authority), authority=authority),
        name=name,
        function=function,
        command_profiles=commands,
        query_profiles=(*COMMON_QUERIES, *queries) if common else queries,
        event_profiles=events,
        parameter_profiles=parameters,
    )
