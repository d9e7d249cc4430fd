"""Replies of a language model, event by event, as various servers send them."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_agents.mind.model.reply import (
    MAX_ARGUMENTS,
    MAX_REPLY,
    MAX_TOOL_CALLS,
    BadReply,
    CallPart,
    Delta,
    Reply,
    Usage,
    estimate_tokens,
    read_delta,
)

from tests.support.chat_server import call_chunk, chunk


def read(*events: object) -> tuple[str, list[tuple[str, str, str]], Usage | None]:
    reply = Reply()
    text = "".join(reply.add(read_delta(json.dumps(each))) for each in events)
    return text, [(call.call_id, call.name, call.text) for call in reply.calls], reply.usage


def test_a_text_and_calls_in_pieces_become_a_reply() -> None:
    events = (
        chunk({"role": "assistant", "content": "", "tool_calls": None}),
        chunk({"content": "Let me "}),
        chunk({"content": "wave."}),
        call_chunk(0, "", "gesture", "call_7"),
        call_chunk(1, '{"place"', "go_to", "call_8"),
        call_chunk(0, '{"name": '),
        call_chunk(1, ': "door"}'),
        call_chunk(0, '"wave"}'),
        chunk({}, "tool_calls"),
        {"choices": [], "usage": {"prompt_tokens": 12, "completion_tokens": 5}},
    )
    calls = [("call_7", "gesture", '{"name": "wave"}'), ("call_8", "go_to", '{"place": "door"}')]
    assert read(*events) == ("Let me wave.", calls, Usage(12, 5))


def test_calls_that_all_have_the_number_0_or_none_are_told_apart_by_their_ids() -> None:
    for index in (0, None):
        events = (
            call_chunk(index, "{}", "where", "a"),
            call_chunk(index, '{"direction":', "look_at", "b"),
            call_chunk(index, '"left"}'),
        )
        assert read(*events)[1] == [("a", "where", "{}"), ("b", "look_at", '{"direction":"left"}')]


def test_a_whole_answer_is_read_as_well() -> None:
    function = {"name": "where", "arguments": {}}
    message = {"content": [{"type": "text", "text": "Hello"}, {"type": "x"}, 1], "tool_calls": [{"function": function}]}
    told = {"choices": [{"message": message}], "usage": {"prompt_tokens": 1, "completion_tokens": 2}}
    assert read(told) == ("Hello", [("call00000", "where", "{}")], Usage(1, 2))


def test_what_says_nothing_adds_nothing() -> None:
    events: tuple[object, ...] = (
        {"choices": []},
        {"choices": [{"delta": None}]},
        {"choices": [{"delta": {"content": None, "reasoning_content": "Hm"}}]},
        {"choices": [{"delta": {"content": []}}], "usage": {"prompt_tokens": True, "completion_tokens": -1}},
        {"choices": [{}], "usage": {"prompt_tokens": 1}},
    )
    for told in events:
        assert read_delta(json.dumps(told)) == Delta()
    assert read_delta('{"usage": {"prompt_tokens": 1, "completion_tokens": 0}}') == Delta(usage=Usage(1, 0))


@pytest.mark.parametrize(
    ("event", "reason"),
    [
        ("{", "no JSON"),
        ("[" * 200_000, "no JSON"),
        ("[1]", "no JSON object"),
        ("{}", "no choices"),
        ('{"choices": {}}', "no choices"),
        ('{"choices": [7]}', "has no delta"),
        ('{"choices": [{"delta": "x"}]}', "has no delta"),
        ('{"choices": [{"delta": {"content": 7}}]}', "no text in the content of what came"),
        ('{"choices": [{"delta": {"tool_calls": {}}}]}', "are no list"),
        ('{"choices": [{"delta": {"tool_calls": [1]}}]}', "no function in a call of a tool in what came"),
        ('{"choices": [{"delta": {"tool_calls": [{"function": 1}]}}]}', "no function in a call of a tool in what came"),
        ('{"error": {"message": "no\\nmemory"}}', "it reports an error: no memory"),
        ('{"error": "overloaded"}', "it reports an error: overloaded"),
    ],
)
def test_what_is_no_reply_is_refused_with_a_reason(event: str, reason: str) -> None:
    with pytest.raises(BadReply, match=reason):
        read_delta(event)


def test_a_reply_has_only_so_many_characters() -> None:
    reply = Reply()
    texts = [reply.add(Delta("x" * 1_500)) for _ in range(4)]
    assert len("".join(texts)) == MAX_REPLY
    assert reply.is_full
    assert reply.written == 4 * 1_500 // 4


def test_a_reply_calls_only_so_many_tools() -> None:
    reply = Reply()
    for index in range(MAX_TOOL_CALLS):
        reply.add(Delta(calls=(CallPart(index, f"c{index}", "where", ""),)))
    with pytest.raises(BadReply, match=f"more than {MAX_TOOL_CALLS} tools"):
        reply.add(Delta(calls=(CallPart(99, "c99", "where", ""),)))


def test_the_arguments_of_a_call_are_only_so_long() -> None:
    reply = Reply()
    reply.add(Delta(calls=(CallPart(0, "c", "where", "x" * MAX_ARGUMENTS),)))
    with pytest.raises(BadReply, match=f"more than {MAX_ARGUMENTS} characters"):
        reply.add(Delta(calls=(CallPart(0, "", "", "x"),)))


def test_a_call_without_a_usable_id_or_name_gets_one() -> None:
    reply = Reply()
    for index, (call_id, name) in enumerate((("", "a b"), ("x" * 201, "n" * 65), ("\n", ""))):
        reply.add(Delta(calls=(CallPart(index, call_id, name, ""),)))
    assert [(call.call_id, call.name) for call in reply.calls] == [(f"call0000{n}", "unknown") for n in range(3)]


@pytest.mark.parametrize(
    ("text", "arguments"),
    [("", {}), ("{}", {}), ('{"a": 1}', {"a": 1}), ("[]", None), ("{", None), ("[" * 8_000, None), ("null", None)],
)
def test_arguments_are_an_object_or_none(text: str, arguments: dict[str, Any] | None) -> None:
    reply = Reply()
    reply.add(Delta(calls=(CallPart(None, "c", "where", text),)))
    assert reply.calls[0].arguments() == arguments


def test_tokens_are_estimated_in_every_script() -> None:
    assert [estimate_tokens(text) for text in ("", "a", "abcd", "abcde", "你好", "你好abc")] == [0, 1, 1, 2, 2, 3]


def test_half_a_character_is_replaced() -> None:
    assert read_delta('{"choices": [{"delta": {"content": "\\ud83d"}}]}').text == "?"
    assert read_delta('{"choices": [{"delta": {"content": "\\ud83d\\ude42"}}]}').text == "🙂"


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.just("\ud800"),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(
                ("choices", "delta", "message", "content", "tool_calls", "function", "arguments", "name", "id", "index")
            )
            | st.sampled_from(("usage", "prompt_tokens", "completion_tokens", "error", "text")),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)
DELTAS = st.builds(lambda added, usage: {"choices": [{"delta": added}], "usage": usage}, JSON, JSON)


@given(st.lists(JSON | DELTAS, max_size=6))
def test_whatever_a_server_sends_it_is_a_reply_or_refused(events: list[Any]) -> None:
    reply, text, refused = Reply(), "", list[str]()
    for event in events:
        try:
            text += reply.add(read_delta(json.dumps(event)))
        except BadReply as error:
            refused.append(str(error))
    text.encode()
    assert all(each.isprintable() for each in refused)
    assert len(text) <= MAX_REPLY
    assert len(reply.calls) <= MAX_TOOL_CALLS
    assert all(call.call_id and call.name.isascii() for call in reply.calls)
