"""The tools that act on a body: each but `call` needs a type of component."""

import pytest
from openrois_agents.tools.abilities import ABILITIES
from openrois_agents.tools.arguments import UseBody
from openrois_agents.tools.instructions import INSTRUCTIONS
from openrois_agents.tools.settings import ACTING, CALL
from openrois_agents.tools.toolbox import TOOLS

pytestmark = pytest.mark.extra(name="mcp")


def test_every_acting_tool_has_its_ability_and_can_be_named_by_a_task() -> None:
    assert set(ACTING) == {*ABILITIES, CALL}
    assert set(ACTING) <= set(TOOLS)
    assert UseBody.model_validate({"tools": list(ACTING)}).tools == list(ACTING)


def test_the_instructions_name_tools_that_there_are() -> None:
    assert {word for word in INSTRUCTIONS.replace(",", "").split() if "_" in word} == {"use_body", "give_back"}
    assert {"use_body", "give_back"} <= set(TOOLS)
    assert len(INSTRUCTIONS) < 1_000
