"""The tools that a language model has in a conversation, where a body is held for it already."""

from collections.abc import Collection, Mapping
from types import MappingProxyType
from typing import Any, Final

from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.toolbox import TOOLS, input_schema

__all__ = ["LOOK", "USABLE", "mistake_in", "tool_schemas"]

LOOK: Final = "look"
"""Shows a picture of the camera: for models that see."""

USABLE: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "gesture": ("name",),
        "go_to": ("place",),
        "look_at": ("direction",),
        LOOK: (),
        "where": (),
        "stop": (),
    }
)
"""Arguments of the tools that make sense here; each is required.

The conversation reserves the body and gives it back, says the text of a reply and hears the visitor; it is not asked
to wait, and `call` could do anything. Of `body` there is one.
"""


def tool_schemas(tools: Collection[str], vocabulary: Vocabulary) -> list[dict[str, Any]]:
    """Return tools as the API takes them; what needs a name is left out where there is none to choose."""
    found = []
    for name, arguments in USABLE.items():
        tool = TOOLS[name]
        choices = (getattr(vocabulary, names) for argument, names in tool.choices.items() if argument in arguments)
        if name in tools and all(choices):
            properties = input_schema(tool, vocabulary)["properties"]
            parameters = {
                "type": "object",
                "properties": {argument: properties[argument] for argument in arguments},
                "required": list(arguments),
                "additionalProperties": False,
            }
            function = {"name": name, "description": tool.description, "parameters": parameters}
            found.append({"type": "function", "function": function})
    return found


def mistake_in(name: str, arguments: Mapping[str, Any] | None, tools: Collection[str]) -> str:
    """Return what is wrong with a call before it is made; nothing where it may be made."""
    if name not in USABLE or name not in tools:
        return f"there is no tool {name!r} here: there are {', '.join(each for each in USABLE if each in tools)}"
    if arguments is None:
        return f"the arguments of {name} have to be a JSON object"
    if set(arguments) - set(USABLE[name]):
        return f"{name} takes {', '.join(USABLE[name]) or 'no arguments'}, and nothing else"
    return ""
