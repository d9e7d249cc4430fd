"""The messages that services and actions exchange, derived from their definitions. Pure.

Source: https://design.ros2.org/articles/actions.html.
"""

from dataclasses import dataclass
from typing import Final

from openrois_robots.ros2.interfaces.definitions import (
    ActionDefinition,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
)

__all__ = ["ActionMessages", "action_messages"]

_GOAL_ID: Final = Field(FieldType("unique_identifier_msgs/msg/UUID"), "goal_id")
_STAMP: Final = Field(FieldType("builtin_interfaces/msg/Time"), "stamp")


@dataclass(frozen=True, slots=True)
class ActionMessages:
    """The services and messages of an action, beside `action_msgs/srv/CancelGoal` and the array of statuses.

    Attributes:
        send_goal: a service.
        get_result: a service.
        feedback: a message.
    """

    send_goal: ServiceDefinition
    get_result: ServiceDefinition
    feedback: MessageDefinition


def action_messages(action: ActionDefinition) -> ActionMessages:
    """Return the services and messages of an action."""
    send, get = f"{action.name}_SendGoal", f"{action.name}_GetResult"
    status = Field(FieldType("int8"), "status")
    return ActionMessages(
        ServiceDefinition(
            send,
            MessageDefinition(f"{send}_Request", (_GOAL_ID, Field(FieldType(action.goal.name), "goal"))),
            MessageDefinition(f"{send}_Response", (Field(FieldType("bool"), "accepted"), _STAMP)),
        ),
        ServiceDefinition(
            get,
            MessageDefinition(f"{get}_Request", (_GOAL_ID,)),
            MessageDefinition(f"{get}_Response", (status, Field(FieldType(action.result.name), "result"))),
        ),
        MessageDefinition(
            f"{action.name}_FeedbackMessage", (_GOAL_ID, Field(FieldType(action.feedback.name), "feedback"))
        ),
    )
