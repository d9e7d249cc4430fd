"""EmergencyStop: the robot stands until a person releases it. A component of OpenRoIS."""

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import Component, ComponentStatus, command
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["EmergencyStop"]


class EmergencyStop(Component, authority="OpenRoIS", function="function"):
    """The robot's own emergency stop. Any application may press it, and none can release it.

    Args:
        robot: the robot.
        api: of it.
    """

    def __init__(self, robot: Kachaka, api: KachakaApi) -> None:
        super().__init__()
        self._robot = robot
        self._api = api

    def condition(self) -> ComponentStatus:
        """Return the status of the link to the robot: a robot with an error can be stopped."""
        return self._robot.link.status

    def problem(self) -> str:
        """Return why the robot is not linked."""
        return self._robot.link.problem

    @command
    async def press(self) -> None:
        """Stop the robot at once, whichever program's command it carries out."""
        response: pb2.SetEmergencyStopResponse = await self._robot.link.during(
            self._api.call("SetEmergencyStop", pb2.EmptyRequest())
        )
        self._robot.texts.require_success(response.result, "stop in an emergency")
