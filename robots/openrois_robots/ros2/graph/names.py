"""Names of ROS 2: of topics, services and actions, relative to a namespace, and as DDS has them. Pure.

Sources: https://design.ros2.org/articles/topic_and_service_names.html, and the packages rmw_dds_common and
rmw_cyclonedds_cpp for the prefixes.
"""

import re
from typing import Final

__all__ = ["dds_topic", "dds_type", "reply_topic", "request_topic", "resolve_name", "ros_type"]

_FULL: Final = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
_MOST: Final = 240
"""Characters of a name: DDS allows 255 with the prefix and the suffix."""
_DDS_TYPE: Final = re.compile(r"(\w+)::(msg|srv|action)::dds_::(\w+)_")


def resolve_name(name: str, namespace: str = "/") -> str:
    """Return a name from the root on: `/robot_1/cmd_vel` for `cmd_vel` in the namespace `/robot_1`.

    Args:
        name: relative to the namespace, or from the root on if it begins with /.
        namespace: begins with /.

    Raises:
        ValueError: it cannot be a name of ROS; a sentence for a person.
    """
    full = name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"
    if not _FULL.fullmatch(full) or "__" in full or len(full) > _MOST:
        raise ValueError(
            f"{name!r} cannot be a name of ROS: it has words of letters, digits and single _ with / between them,"
            f" none of which begins with a digit, and at most {_MOST} characters"
        )
    return full


def dds_topic(name: str) -> str:
    """Return the DDS topic of a topic."""
    return f"rt{name}"


def request_topic(service: str) -> str:
    """Return the DDS topic with the requests to a service."""
    return f"rq{service}Request"


def reply_topic(service: str) -> str:
    """Return the DDS topic with the replies of a service."""
    return f"rr{service}Reply"


def dds_type(name: str) -> str:
    """Return the name that DDS has for a type: `geometry_msgs::msg::dds_::Twist_`."""
    package, kind, base = name.split("/")
    return f"{package}::{kind}::dds_::{base}_"


def ros_type(name: str) -> str:
    """Return the name that ROS has for a type of DDS; one that is no type of ROS stays as it is."""
    found = _DDS_TYPE.fullmatch(name)
    return name if found is None else "/".join(found.groups())
