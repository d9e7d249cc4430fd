"""The tools that act on a body: each but `call` needs a type of component."""

import pytest
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.arguments import UseBody
from openrois_agents.tools.settings import ACTING, CALL
from openrois_agents.tools.toolbox import TOOLS

pytestmark = pytest.mark.extra(name="mcp")


def test_every_acting_tool_has_its_ability_and_can_be_named_by_a_task() -> None:
    assert set(ACTING) == {*ABILITIES, CALL}
    assert set(ACTING) <= set(TOOLS)
    assert UseBody.model_validate({"tools": list(ACTING)}).tools == list(ACTING)
