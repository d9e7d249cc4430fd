"""The arguments of tools: what fits is read, and each mistake is named."""

from typing import Any

import pytest
from openrois_agents.tools.arguments import Arguments, Call, GoTo, LookAt, Nothing, Say, UseBody, read_arguments

from openrois.errors import BadParameter

pytestmark = pytest.mark.extra(name="mcp")


@pytest.mark.parametrize(
    ("kind", "given"),
    [
        (Nothing, None),
        (Say, {"text": "Good day!"}),
        (GoTo, {"place": "plant"}),
        (GoTo, {"x": 1, "y": -2.5, "facing": 1}),
        (LookAt, {"direction": "left"}),
        (LookAt, {"x": 0.5}),
        (Call, {"component": "robot/door", "kind": "query", "name": "view"}),
        (Call, {"component": "robot/door", "kind": "get_parameters"}),
        (UseBody, {"tools": ["say", "call"]}),
    ],
)
def test_what_fits_is_read(kind: type[Arguments], given: Any) -> None:
    assert read_arguments("tool", kind, given).model_dump(exclude_unset=True) == (given or {})


@pytest.mark.parametrize(
    ("kind", "given", "said"),
    [
        (Nothing, {"x": 1}, "x: Extra inputs are not permitted"),
        (Nothing, [1], "arguments: Input should be"),
        (Say, {}, "text: Field required"),
        (Say, {"text": "x", "volume": "loud"}, "volume: Input should be a valid integer"),
        (Say, {"text": "x", "language": "english"}, "language: String should match"),
        (GoTo, {}, "arguments: give a place, or x and y"),
        (GoTo, {"x": 1}, "give a place, or x and y"),
        (GoTo, {"place": "plant", "x": 1}, "give a place, or x and y"),
        (GoTo, {"place": "plant", "x": 1, "y": 1}, "give a place, or x and y"),
        (GoTo, {"place": "plant", "facing": 1}, "facing goes with x and y"),
        (GoTo, {"x": float("nan"), "y": 0}, "x: Input should be a finite number"),
        (LookAt, {}, "give a direction, or x and y"),
        (LookAt, {"direction": "left", "x": 1}, "give a direction, or x and y"),
        (LookAt, {"x": 2}, "x: Input should be less than or equal to 1"),
        (Call, {"component": "a/b", "kind": "query"}, "query and command need a name"),
        (Call, {"component": "a/b", "kind": "get_parameters", "name": "x"}, "nothing else takes one"),
        (UseBody, {"tools": ["fly"]}, "tools.0: Input should be 'say'"),
        (UseBody, {"tools": []}, "tools: List should have at least 1 item"),
    ],
)
def test_each_mistake_is_named(kind: type[Arguments], given: Any, said: str) -> None:
    with pytest.raises(BadParameter, match=r"^tool: ") as refused:
        read_arguments("tool", kind, given)
    assert said in str(refused.value)
