"""SystemInformation (component 1): where a robot is, and whether its engine works."""

from datetime import datetime
from typing import Annotated, Final

from openrois.catalog.component_type import ComponentType, QueryType
from openrois.catalog.payload import Data, Payload
from openrois.types.codes import ComponentStatus

__all__ = ["SYSTEM_INFORMATION", "EngineStatusResult", "RobotPositionResult"]


class RobotPositionResult(Payload):
    """Where the robot, its sensors and its actuators are; the lists run in parallel."""

    position_data: Annotated[tuple[str, ...], Data("String[]", "M", "a position x,y,th for each ref")]
    robot_ref: Annotated[tuple[str, ...], Data("RoISIdentifier[]", "M", "whose positions they are")]
    timestamp: Annotated[datetime, Data("DateTime", "M", "when they were measured")]


class EngineStatusResult(Payload):
    """Whether the engine works."""

    status: Annotated[ComponentStatus, Data("Component_Status", "M", "the engine's status")]
    operable_time: Annotated[
        datetime | None,
        Data("DateTime", "O", "when it can be used", note="a list in IDL and text"),
    ] = None


SYSTEM_INFORMATION: Final = ComponentType(
    code="SystemInformation",
    name="system_info",
    description="Where the robot is and whether its engine works; mandatory where the engine is a physical unit.",
    source="SystemInformation.xml",
    queries=(
        QueryType("robot_position", "Ask where the robot and its parts are.", RobotPositionResult),
        QueryType("engine_status", "Ask whether the engine works.", EngineStatusResult),
    ),
)
"""It has no RoIS_Common in XML and text; the IDL's query interface inherits it."""
