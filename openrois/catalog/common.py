"""RoIS_Common: the messages that every basic component but SystemInformation has."""

from typing import Annotated, Final

from openrois.catalog.component_type import CommandType, ComponentType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.types.codes import ComponentStatus

__all__ = ["ROIS_COMMON", "ComponentStatusResult"]


class ComponentStatusResult(Payload):
    """What a component is able to do now."""

    status: Annotated[ComponentStatus, Data("Component_Status", "M", "the component's status")]


ROIS_COMMON: Final = ComponentType(
    code="RoISCommon",
    name="rois_common",
    description="Messages shared by the basic components.",
    source="RoISCommon.xml",
    commands=(
        CommandType("start", "Begin what the component is for."),
        CommandType("stop", "End it."),
        CommandType("suspend", "Pause it."),
        CommandType("resume", "Go on with it."),
    ),
    queries=(QueryType("component_status", "Ask what the component is able to do now.", ComponentStatusResult),),
    # With a capital C, here and wherever another type includes it.
    spelled_urn="urn:x-rois:def:Component:OMG::RoISCommon",
)
