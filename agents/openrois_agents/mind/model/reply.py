"""The reply of a language model as it arrives: text, calls of tools, and what it has used. Pure."""

import json
import re
from dataclasses import dataclass
from typing import Any, Final

from openrois_agents.mind.model.thoughts import Thoughts

__all__ = [
    "MAX_ARGUMENTS",
    "MAX_REPLY",
    "MAX_TOOL_CALLS",
    "BadReply",
    "CallPart",
    "Delta",
    "Reply",
    "ToolCall",
    "Usage",
    "estimate_tokens",
    "read_delta",
]

MAX_REPLY: Final = 4_000
"""Characters of a reply; it is cut there."""

MAX_TOOL_CALLS: Final = 16
"""Calls of tools in a reply, of which some run; with more it is refused."""

MAX_ARGUMENTS: Final = 8_000
"""Characters of the arguments of a call; with more the reply is refused."""

_MAX_ID: Final = 200
_MAX_REASON: Final = 300
_MOST_TOKENS: Final = 100_000_000
_CHARACTERS_PER_TOKEN: Final = 4
_NAME: Final = re.compile(r"[A-Za-z0-9_-]{1,64}")


class BadReply(ValueError):
    """What came is no reply, or one that is refused; the text says why."""


@dataclass(frozen=True, slots=True)
class CallPart:
    """A part of a call of a tool.

    Attributes:
        index: of the call in the reply; None where the server does not say it.
        call_id, name: of the call; empty in most parts.
        arguments: the next characters of them.
    """

    index: int | None
    call_id: str
    name: str
    arguments: str


@dataclass(frozen=True, slots=True)
class Usage:
    """Tokens that a reply has used.

    Attributes:
        read: of what was sent.
        written: of the reply.
    """

    read: int
    written: int


@dataclass(frozen=True, slots=True)
class Delta:
    """What one event adds to a reply."""

    text: str = ""
    calls: tuple[CallPart, ...] = ()
    usage: Usage | None = None


@dataclass(slots=True)
class ToolCall:
    """A call of a tool.

    Attributes:
        call_id: by which its result is told.
        name: of the tool; `unknown` where what the model gave is no name.
        text: its arguments, as JSON.
    """

    call_id: str
    name: str
    text: str = ""

    def arguments(self) -> dict[str, Any] | None:
        """Return the arguments; None where they are no JSON object."""
        try:
            read = json.loads(self.text or "{}")
        except (ValueError, RecursionError):
            return None
        return read if isinstance(read, dict) else None


class Reply:
    """A reply so far.

    Attributes:
        usage: what it has used, if the server says so.
    """

    def __init__(self) -> None:
        self.usage: Usage | None = None
        self._characters = 0
        self._calls: list[ToolCall] = []
        self._by_index: dict[int, ToolCall] = {}
        self._written = 0
        self._thoughts = Thoughts()

    @property
    def is_full(self) -> bool:
        """Whether it has as much text as a reply may have."""
        return self._characters >= MAX_REPLY

    @property
    def calls(self) -> tuple[ToolCall, ...]:
        """The calls so far; their arguments are whole when the reply is."""
        return tuple(self._calls)

    @property
    def written(self) -> int:
        """Tokens of the reply, estimated."""
        return self._written

    def add(self, delta: Delta) -> str:
        """Add what arrived, and return what of it is to be said, cut where the reply is full.

        Raises:
            BadReply: it calls too many tools, or with too long arguments.
        """
        self.usage = delta.usage or self.usage
        text = self._thoughts.leave_out(delta.text)[: MAX_REPLY - self._characters]
        self._characters += len(text)
        self._written += estimate_tokens(delta.text)
        for part in delta.calls:
            self._add_part(part)
        return text

    def _add_part(self, part: CallPart) -> None:
        call = self._call_of(part)
        call.text += part.arguments
        self._written += estimate_tokens(part.arguments)
        if len(call.text) > MAX_ARGUMENTS:
            raise BadReply(f"it calls a tool with more than {MAX_ARGUMENTS} characters of arguments")

    def _call_of(self, part: CallPart) -> ToolCall:
        """Return the call that a part belongs to.

        Some servers number no calls, or give all of them the same number: another id is another call.
        """
        last = self._calls[-1] if self._calls else None
        known = last if part.index is None else self._by_index.get(part.index)
        if known is not None and part.call_id in ("", known.call_id):
            return known
        if len(self._calls) >= MAX_TOOL_CALLS:
            raise BadReply(f"it calls more than {MAX_TOOL_CALLS} tools at once")
        # The form of an id that every server takes.
        own = f"call{len(self._calls):05}"
        call_id = part.call_id if 0 < len(part.call_id) <= _MAX_ID and part.call_id.isprintable() else own
        call = ToolCall(call_id, part.name if _NAME.fullmatch(part.name) else "unknown")
        self._calls.append(call)
        if part.index is not None:
            self._by_index[part.index] = call
        return call


def estimate_tokens(text: str) -> int:
    """Estimate the tokens of a text: a quarter of what is ASCII, and each other character."""
    foreign = sum(not each.isascii() for each in text)
    return foreign + -(-(len(text) - foreign) // _CHARACTERS_PER_TOKEN)


def read_delta(event: str) -> Delta:
    """Read an event of a stream, or a whole answer of a server that does not stream.

    Raises:
        BadReply: it is neither, or says that the server has failed.
    """
    try:
        told = json.loads(event)
    except (ValueError, RecursionError):
        raise BadReply("what came is no JSON") from None
    if not isinstance(told, dict):
        raise BadReply("what came is no JSON object")
    if error := told.get("error"):
        said = error.get("message") if isinstance(error, dict) else error
        raise BadReply(f"it reports an error: {_line(str(said))}")
    usage = _read_usage(told.get("usage"))
    choices = told.get("choices")
    if choices is None and usage is not None:
        return Delta(usage=usage)
    if not isinstance(choices, list):
        raise BadReply("there are no choices in what came")
    if not choices:
        return Delta(usage=usage)
    choice = choices[0]
    # A whole answer has a message where a stream has deltas.
    added = choice.get("delta", choice.get("message")) if isinstance(choice, dict) else choice
    if added is None:
        added = {}
    if not isinstance(added, dict):
        raise BadReply("a choice in what came has no delta")
    return Delta(_read_content(added.get("content")), _read_calls(added.get("tool_calls")), usage)


def _read_content(content: Any) -> str:
    if content is None or isinstance(content, str):
        return _whole(content or "")
    if not isinstance(content, list):
        raise BadReply("no text in the content of what came")
    texts = [each.get("text") for each in content if isinstance(each, dict)]
    return _whole("".join(each for each in texts if isinstance(each, str)))


def _read_calls(calls: Any) -> tuple[CallPart, ...]:
    if calls is None:
        return ()
    if not isinstance(calls, list):
        raise BadReply("the calls of tools in what came are no list")
    return tuple(map(_read_call, calls))


def _read_call(call: Any) -> CallPart:
    function = call.get("function", {}) if isinstance(call, dict) else None
    if not isinstance(function, dict):
        raise BadReply("no function in a call of a tool in what came")
    index, arguments = call.get("index"), function.get("arguments")
    if isinstance(arguments, dict):
        # Some servers give the object, not its text.
        arguments = json.dumps(arguments)
    return CallPart(
        index if isinstance(index, int) and not isinstance(index, bool) else None,
        _text(call.get("id")),
        _text(function.get("name")),
        _text(arguments),
    )


def _read_usage(usage: Any) -> Usage | None:
    if not isinstance(usage, dict):
        return None
    read, written = _count(usage.get("prompt_tokens")), _count(usage.get("completion_tokens"))
    return None if read is None or written is None else Usage(read, written)


def _count(value: Any) -> int | None:
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= _MOST_TOKENS else None


def _text(value: Any) -> str:
    return _whole(value) if isinstance(value, str) else ""


def _whole(text: str) -> str:
    """Return a text without halves of characters, which JSON can carry and nothing else."""
    return text.encode("utf-8", "replace").decode()


def _line(text: str) -> str:
    return "".join(each if each.isprintable() else " " for each in _whole(text))[:_MAX_REASON]
