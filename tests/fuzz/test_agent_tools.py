"""Whatever a language model asks for: each tool answers or gives a reason, and in the end the body is free."""

import asyncio
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_agents.tools.failures import failure
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings
from openrois_agents.tools.toolbox import TOOLS, call_tool

from openrois.testing import memory_gateway
from tests.support.actors import Actor

pytestmark = pytest.mark.extra(name="mcp")

WORDS = st.sampled_from(
    (
        *("robot", "avatar", "", "plant", "nod", "wave", "say", "go_to", "call", "gesture", "look_at", "left", "en"),
        *("robot/door", "robot/navigation", "robot/hearing", "gateway/x", "open", "stop", "start", "view", "things"),
        *(
            "heard",
            "reached_target",
            "query",
            "command",
            "get_parameters",
            "set_parameters",
            "speed",
            "self",
            "times",
            "\ud800",
        ),
    )
)
SCALARS = st.one_of(WORDS, st.none(), st.booleans(), st.integers(-3, 3), st.floats(allow_nan=True), st.text(max_size=8))
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3), max_leaves=4
)
NAMES = st.sampled_from(sorted({name for tool in TOOLS.values() for name in tool.arguments.model_fields}))
ARGUMENTS = st.dictionaries(NAMES, VALUES, max_size=4)


@st.composite
def calls(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    """Draw a call of a tool, with its own arguments more often than with others."""
    name = draw(st.sampled_from(sorted(TOOLS)))
    fields = sorted(TOOLS[name].arguments.model_fields)
    own = st.dictionaries(st.sampled_from(fields), VALUES, max_size=4) if fields else st.just({})
    arguments = draw(st.one_of(own, own, ARGUMENTS))
    if name in ("wait_for_event", "listen", "ask_visitor"):
        arguments["seconds"] = 0.001
    return name, arguments


async def _quietly(_seconds: float, _message: str) -> None:
    pass


async def _kind_of_failure(session: Session, name: str, arguments: dict[str, Any]) -> tuple[str, str]:
    """Call a tool; return why it failed, two empty texts where it did not."""
    try:
        await call_tool(session, name, arguments, _quietly)
    except Exception as error:
        return failure(name, error)
    return "", ""


async def _try_all(asked: list[tuple[str, dict[str, Any]]]) -> None:
    async with memory_gateway(*Actor().parts) as gateway:
        async with Session(gateway.client, ToolSettings(movements=6_000)) as session:
            for name, arguments in asked:
                kind, sentence = await _kind_of_failure(session, name, arguments)
                assert kind != "Error", (name, arguments)
                assert sentence.isprintable()
        async with gateway.client() as other:
            (info,) = await other.bodies()
            assert info.free, asked


@settings(max_examples=60)
@given(st.lists(calls(), min_size=1, max_size=12))
def test_each_tool_answers_or_gives_a_reason(asked: list[tuple[str, dict[str, Any]]]) -> None:
    first: list[tuple[str, dict[str, Any]]] = [("use_body", {"tools": ["say", "gesture", "go_to", "call"]})]
    asyncio.run(_try_all(first + asked))
