"""Definitions by name: those of a folder of the user's, then those of a distribution of ROS that come with this one."""

import re
from pathlib import Path
from typing import Final

from openrois_robots.ros2.interfaces.definitions import (
    ActionDefinition,
    DefinitionError,
    MessageDefinition,
    ServiceDefinition,
    parse_action,
    parse_message,
    parse_service,
)
from openrois_robots.ros2.interfaces.derived import action_messages

__all__ = ["DEFAULT_DISTRIBUTION", "DISTRIBUTIONS", "Interfaces"]

DISTRIBUTIONS: Final = ("humble", "jazzy", "kilted", "lyrical")
"""Distributions of ROS whose definitions come with this one."""
DEFAULT_DISTRIBUTION: Final = "jazzy"

_BUNDLED: Final = Path(__file__).parent
_NAME: Final = re.compile(r"([a-z][a-z0-9_]*)/(msg|srv|action)/([A-Z][A-Za-z0-9]*)")


class Interfaces:
    """Reads definitions when they are asked for.

    Args:
        distribution: one of `DISTRIBUTIONS`.
        folder: holds `package/msg/Name.msg` and so on, as `share` of an installed ROS does; None: there is none.
    """

    def __init__(self, distribution: str = DEFAULT_DISTRIBUTION, folder: Path | None = None) -> None:
        self.distribution = distribution
        self._folders: tuple[Path, ...] = (
            *(() if folder is None else (folder,)),
            _BUNDLED / f"share_{distribution}",
            _BUNDLED / "share",
        )
        self._messages: dict[str, MessageDefinition] = {}

    def message(self, name: str) -> MessageDefinition:
        """Return the definition of a message.

        Args:
            name: `geometry_msgs/msg/Twist`, or a message of a service or an action that was asked for before.

        Raises:
            DefinitionError: there is none of this name, or its text is none; the sentence says where it was sought.
        """
        found = self._messages.get(name)
        if found is None:
            found = self._messages[name] = parse_message(name, self._text(name, "msg"))
        return found

    def service(self, name: str) -> ServiceDefinition:
        """Return the definition of a service, `std_srvs/srv/SetBool`; raises as `message`."""
        service = parse_service(name, self._text(name, "srv"))
        self._add_service(service)
        return service

    def action(self, name: str) -> ActionDefinition:
        """Return the definition of an action, `nav2_msgs/action/NavigateToPose`; raises as `message`."""
        action = parse_action(name, self._text(name, "action"))
        derived = action_messages(action)
        for part in (action.goal, action.result, action.feedback, derived.feedback):
            self._messages[part.name] = part
        self._add_service(derived.send_goal)
        self._add_service(derived.get_result)
        return action

    def _add_service(self, service: ServiceDefinition) -> None:
        self._messages[service.request.name] = service.request
        self._messages[service.response.name] = service.response

    def _text(self, name: str, kind: str) -> str:
        found = _NAME.fullmatch(name)
        if found is None or found[2] != kind:
            raise DefinitionError(f"{name!r} is no name of an interface: expected package/{kind}/Name")
        for folder in self._folders:
            path: Path = folder / f"{name}.{kind}"
            try:
                return path.read_text(encoding="utf-8")
            except FileNotFoundError:
                continue
            except (OSError, UnicodeDecodeError) as error:
                raise DefinitionError(f"{path} cannot be read: {error}") from None
        raise DefinitionError(
            f"{name} is not known: name the folder that has it as `interfaces` of [ros], where ROS is installed"
            f" most often /opt/ros/{self.distribution}/share"
        )
