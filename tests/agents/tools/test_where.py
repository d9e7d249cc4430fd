"""Where a body is: its position, and the places that it knows, each also where the other is not to be had."""

import pytest
from openrois_agents.tools.arguments import Where
from openrois_agents.tools.sensing import where_is
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

from openrois.adapter import ComponentFailed, components
from openrois.catalog.system_information import RobotPositionResult
from openrois.testing import memory_gateway
from tests.support.actors import Surroundings

pytestmark = pytest.mark.extra(name="mcp")


class Lost(components.SystemInformation):
    """A body that has lost its way."""

    async def robot_position(self) -> RobotPositionResult:
        raise ComponentFailed("the map does not fit\nanything that is seen")


async def _quietly(_seconds: float, _message: str) -> None:
    pass


async def test_places_are_answered_where_the_position_fails_and_why() -> None:
    async with (
        memory_gateway(Lost(), Surroundings()) as gateway,
        Session(gateway.client, ToolSettings()) as session,
    ):
        answer = await where_is(session, Where(body=None), _quietly)
    assert answer.data["places"]["plant"] == "1.0,2.0,0.0"
    assert "position" not in answer.data
    assert answer.data["no_position"].startswith("ComponentFailed: ")
    assert "the map does not fit anything that is seen" in answer.data["no_position"]
    assert answer.data["no_position"] in answer.text


async def test_without_places_the_reason_is_the_failure() -> None:
    async with memory_gateway(Lost()) as gateway, Session(gateway.client, ToolSettings()) as session:
        with pytest.raises(ComponentFailed, match="the map does not fit"):
            await where_is(session, Where(body=None), _quietly)
