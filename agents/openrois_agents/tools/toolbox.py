"""The toolbox: every tool with its description, its arguments and its work, by name."""

from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from openrois_agents.tools import acting, calling, sensing, tasks
from openrois_agents.tools.answer import Answer
from openrois_agents.tools.arguments import (
    Arguments,
    AskVisitor,
    Call,
    Gesture,
    GoTo,
    Listen,
    Look,
    LookAt,
    Nothing,
    Say,
    Stop,
    UseBody,
    WaitForEvent,
    Where,
    read_arguments,
)
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.running import Progress
from openrois_agents.tools.session import Session

__all__ = ["TOOLS", "Tool", "call_tool", "input_schema"]


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool.

    Attributes:
        description: for a language model.
        arguments: their type.
        work: does it.
        reads_only: whether it changes nothing around the body.
        choices: the names of `Vocabulary` by the argument that takes one of them.
        ends_what_runs: whether it is called however many calls run.
    """

    description: str
    arguments: type[Arguments]
    work: Callable[[Session, Any, Progress], Awaitable[Answer]]
    reads_only: bool = False
    choices: Mapping[str, str] = field(default_factory=dict)
    ends_what_runs: bool = False


_BODY: Final = MappingProxyType({"body": "bodies"})

TOOLS: Final[Mapping[str, Tool]] = MappingProxyType(
    {
        "bodies": Tool("List the bodies: which are free, and which tools act on each.", Nothing, tasks.bodies, True),
        "use_body": Tool(
            "Reserve a body for a task, whichever is free unless one is named, with the tools that the task needs.",
            UseBody,
            tasks.use_body,
            choices=_BODY,
        ),
        "say": Tool("Say a text through the body; returns when it was heard.", Say, acting.say),
        "gesture": Tool(
            "Make a gesture; returns at its end.",
            Gesture,
            acting.gesture,
            choices=MappingProxyType({"name": "gestures"}),
        ),
        "go_to": Tool(
            "Go to a place, or to x and y; returns on arrival.",
            GoTo,
            acting.go_to,
            choices=MappingProxyType({"place": "places"}),
        ),
        "look_at": Tool("Turn the eyes of the body.", LookAt, acting.look_at),
        "look": Tool("See what the body's camera sees now.", Look, sensing.look, True, _BODY),
        "where": Tool(
            "Tell where the body is, and the places and persons that it knows.", Where, sensing.where_is, True, _BODY
        ),
        "listen": Tool("Wait for what a visitor says.", Listen, sensing.listen, True, _BODY),
        "ask_visitor": Tool("Say a question, and wait for what a visitor answers.", AskVisitor, sensing.ask_visitor),
        "wait_for_event": Tool(
            "Wait for events of the body, or for what happens to it, such as stopped_by_a_person or body_lost.",
            WaitForEvent,
            sensing.wait_for_event,
            True,
            MappingProxyType({"body": "bodies", "events": "events"}),
        ),
        "stop": Tool(
            "Stop everything that a body does, at once.", Stop, tasks.stop, choices=_BODY, ends_what_runs=True
        ),
        "give_back": Tool(
            "End the task: stop what runs, and release the body.", Nothing, tasks.give_back, ends_what_runs=True
        ),
        "call": Tool(
            "Send any other message to a component: see its profile, the resource openrois://profile/{body}.",
            Call,
            calling.call,
        ),
    }
)
"""By name, in the order in which they are listed."""


def input_schema(tool: Tool, vocabulary: Vocabulary) -> dict[str, Any]:
    """Return the JSON Schema of a tool's arguments, with the names that can be chosen now."""
    schema: dict[str, Any] = tool.arguments.model_json_schema()
    properties = {name: _brief(each) for name, each in schema["properties"].items()}
    for argument, names in tool.choices.items():
        if choices := list(getattr(vocabulary, names)):
            text = properties[argument]
            # Of events the log has others, too: those names are examples.
            text.get("items", text)["examples" if "items" in text else "enum"] = choices
    brief = {"type": "object", "properties": properties, "additionalProperties": False}
    return brief | ({"required": schema["required"]} if "required" in schema else {})


def _brief(schema: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of an argument in fewer words: one that may be left out need not be null as well."""
    options = [each for each in schema.get("anyOf", ()) if each != {"type": "null"}]
    whole = {**options[0], **schema} if len(options) == 1 else schema
    return {name: each for name, each in whole.items() if name not in ("anyOf", "title") and each is not None}


async def call_tool(session: Session, name: str, arguments: Any, progress: Progress) -> Answer:
    """Call a tool.

    Raises:
        KeyError: there is no such tool.
        Exception: it failed; see `failure`.
    """
    tool = TOOLS[name]
    given = read_arguments(name, tool.arguments, arguments)
    async with session.call(passes=tool.ends_what_runs):
        return await tool.work(session, given, progress)
