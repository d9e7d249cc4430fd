"""The tools that a language model has in a conversation."""

import jsonschema
import pytest
from openrois_agents.mind.model.tool_choice import USABLE, mistake_in, tool_schemas
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.toolbox import TOOLS

from tests.support.mind_stage import NAMES


def test_of_the_tools_those_are_withheld_that_make_no_sense_in_a_conversation() -> None:
    withheld = {"bodies", "use_body", "give_back", "say", "listen", "ask_visitor", "wait_for_event", "call"}
    assert set(USABLE) | withheld == set(TOOLS)
    assert not set(USABLE) & withheld


def test_a_schema_names_what_can_be_chosen_and_no_body() -> None:
    schemas = {each["function"]["name"]: each["function"]["parameters"] for each in tool_schemas(USABLE, NAMES)}
    assert list(schemas) == list(USABLE)
    assert schemas["gesture"]["properties"]["name"]["enum"] == ["bow", "wave"]
    assert schemas["go_to"]["properties"]["place"]["enum"] == ["door", "plant"]
    assert schemas["look_at"]["properties"]["direction"]["enum"] == ["ahead", "left", "right", "up", "down"]
    for name, schema in schemas.items():
        jsonschema.Draft202012Validator.check_schema(schema)
        assert schema["required"] == list(schema["properties"]) == list(USABLE[name])
        assert "body" not in schema["properties"]


def test_what_needs_a_name_is_left_out_where_there_is_none() -> None:
    names = [each["function"]["name"] for each in tool_schemas(USABLE, Vocabulary())]
    assert names == ["look_at", "look", "where", "stop"]
    assert [each["function"]["name"] for each in tool_schemas({"where"}, NAMES)] == ["where"]


@pytest.mark.parametrize(
    ("name", "arguments", "mistake"),
    [
        ("gesture", {"name": "wave"}, ""),
        ("stop", {}, ""),
        ("use_body", {}, "there is no tool 'use_body' here: there are gesture, go_to, look_at, where, stop"),
        ("look", {}, "there is no tool 'look' here: there are gesture, go_to, look_at, where, stop"),
        ("where", None, "the arguments of where have to be a JSON object"),
        ("stop", {"body": "other"}, "stop takes no arguments, and nothing else"),
        ("go_to", {"place": "door", "x": 1}, "go_to takes place, and nothing else"),
    ],
)
def test_a_call_that_may_not_be_made_is_answered_with_its_mistake(
    name: str, arguments: dict[str, object] | None, mistake: str
) -> None:
    assert mistake_in(name, arguments, set(USABLE) - {"look"}) == mistake
