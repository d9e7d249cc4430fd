"""The conversation as a language model is told it: bounded, and with what was heard, not with what was made. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

from openrois_agents.mind.model.reply import ToolCall
from openrois_agents.tools.untrusted import PICTURE_WARNING

__all__ = ["MAX_HISTORY", "MAX_RESULT", "MAX_TURNS", "History"]

MAX_TURNS: Final = 24
"""Turns that are told; the oldest is left out."""

MAX_HISTORY: Final = 24_000
"""Characters of the turns that are told, without pictures: the oldest turns are left out, then what tools told in the
newest one, the oldest first. What the visitor said last is told however long it is."""

MAX_RESULT: Final = 4_000
"""Characters of a tool's result; what is longer is cut."""

_NOT_RUN: Final = "It was not run to its end: the visitor has interrupted."
_WITHHELD: Final = "The picture is not shown: a visitor is here who does not consent to that."
_LEFT_OUT: Final = "Left out: there was too much of it."
_CUT: Final = " ..."


@dataclass(slots=True)
class _Reply:
    """A reply of the model: what was said of it, its calls, and their results and pictures by the ids of the calls."""

    said: list[str] = field(default_factory=list)
    calls: tuple[ToolCall, ...] = ()
    results: dict[str, str] = field(default_factory=dict)
    pictures: dict[str, str] = field(default_factory=dict)

    @property
    def size(self) -> int:
        called = sum(2 * len(each.call_id) + len(each.name) + len(each.text) for each in self.calls)
        return sum(map(len, self.said)) + called + sum(map(len, self.results.values()))

    def leave_out_details(self) -> None:
        """Tell no more than which tools were called."""
        self.calls = tuple(replace(each, text="") for each in self.calls)
        self.results = dict.fromkeys(self.results, _LEFT_OUT)

    def leave_out_calls(self) -> None:
        """Tell nothing of its calls."""
        self.calls, self.results, self.pictures = (), {}, {}

    def messages(self, *, with_pictures: bool) -> list[dict[str, Any]]:
        text = " ".join(self.said)
        if not self.calls:
            return [{"role": "assistant", "content": text}] if text else []
        calls = [
            {
                "id": call.call_id,
                "type": "function",
                # Arguments that are none were told to be a mistake; a server may refuse them here.
                "function": {"name": call.name, "arguments": call.text if call.arguments() else "{}"},
            }
            for call in self.calls
        ]
        found: list[dict[str, Any]] = [{"role": "assistant", "content": text or None, "tool_calls": calls}]
        found += (
            {"role": "tool", "tool_call_id": call.call_id, "content": self.results.get(call.call_id, _NOT_RUN)}
            for call in self.calls
        )
        if with_pictures and self.pictures:
            # The result of a tool is a text; a picture is taken as a visitor's.
            warning = {"type": "text", "text": PICTURE_WARNING}
            found.append({"role": "user", "content": [warning, *map(_picture, self.pictures.values())]})
        return found


@dataclass(slots=True)
class _Turn:
    """What a visitor said, and the replies to it."""

    text: str
    replies: list[_Reply] = field(default_factory=list)

    @property
    def size(self) -> int:
        return len(self.text) + sum(each.size for each in self.replies)


class History:
    """The turns of a conversation; the newest is open."""

    def __init__(self) -> None:
        self._turns: list[_Turn] = []

    def begin_turn(self, text: str) -> None:
        """Begin a turn with what a visitor said."""
        self._turns.append(_Turn(text, [_Reply()]))
        del self._turns[:-MAX_TURNS]
        self._leave_out_turns()

    def add_said(self, sentence: str) -> None:
        """Add a sentence of the reply that is arriving."""
        self._reply.said.append(sentence)

    def add_calls(self, calls: Sequence[ToolCall]) -> None:
        """End the reply with the calls of tools that it makes."""
        self._reply.calls = tuple(calls)

    def add_result(self, call: ToolCall, text: str) -> None:
        """Add the result of a call."""
        self._reply.results[call.call_id] = text if len(text) <= MAX_RESULT else f"{text[:MAX_RESULT]}{_CUT}"

    def add_picture(self, call: ToolCall, address: str) -> None:
        """Add a picture that a call has brought, as a `data:` address; the newest is told, during this turn alone."""
        for reply in self._turns[-1].replies:
            reply.pictures.clear()
        self._reply.pictures[call.call_id] = address

    def withhold_pictures(self) -> None:
        """Tell no picture of this turn, and that it is not shown."""
        for reply in self._turns[-1].replies:
            reply.results |= dict.fromkeys(reply.pictures, _WITHHELD)
            reply.pictures.clear()

    def go_on(self) -> None:
        """Begin another reply of the same turn, behind the results of calls."""
        self._leave_out_turns()
        self._leave_out_calls()
        self._turns[-1].replies.append(_Reply())

    def cut(self, heard: str) -> None:
        """Keep of what was said in this turn only what was heard: the answer was interrupted."""
        if not self._turns:
            return
        # Where words are joined is not told; the characters are.
        left = sum(not each.isspace() for each in heard)
        for reply in self._turns[-1].replies:
            text = " ".join(reply.said)
            kept, left = _first(text, left)
            reply.said = [kept] if kept else []

    def forget_turns(self) -> None:
        """Forget the conversation."""
        self._turns.clear()

    def messages(self, instructions: str) -> list[dict[str, Any]]:
        """Return the messages for a request, behind instructions; each call of a tool has its result."""
        found: list[dict[str, Any]] = [{"role": "system", "content": instructions}]
        for turn in self._turns:
            _add_visitor(found, turn.text)
            for reply in turn.replies:
                found += reply.messages(with_pictures=turn is self._turns[-1])
        return found

    def _leave_out_turns(self) -> None:
        sizes = [each.size for each in self._turns]
        while len(sizes) > 1 and sum(sizes) > MAX_HISTORY:
            del self._turns[0], sizes[0]

    def _leave_out_calls(self) -> None:
        turn = self._turns[-1]
        # Ids and names alone may be too much where a server means harm.
        for leave_out in (_Reply.leave_out_details, _Reply.leave_out_calls):
            for reply in turn.replies:
                if turn.size <= MAX_HISTORY:
                    return
                leave_out(reply)

    @property
    def _reply(self) -> _Reply:
        return self._turns[-1].replies[-1]


def _add_visitor(messages: list[dict[str, Any]], text: str) -> None:
    """Add what a visitor said; many servers want it to follow a reply, so what was not answered is joined."""
    last = messages[-1]
    if last["role"] == "user" and isinstance(last["content"], str):
        last["content"] += f"\n{text}"
    else:
        messages.append({"role": "user", "content": text})


def _picture(address: str) -> dict[str, Any]:
    return {"type": "image_url", "image_url": {"url": address}}


def _first(text: str, count: int) -> tuple[str, int]:
    """Return the text up to so many characters that are no space, and how many are left for what follows."""
    for at, each in enumerate(text):
        if each.isspace():
            continue
        if count == 0:
            return (f"{text[:at].rstrip()}{_CUT}" if at else ""), 0
        count -= 1
    return text, count
