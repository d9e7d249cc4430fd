"""What a language model is told of the conversation."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_agents.mind.model.history import MAX_HISTORY, MAX_RESULT, MAX_TURNS, History
from openrois_agents.mind.model.model_mind import MAX_ROUNDS
from openrois_agents.mind.model.reply import MAX_ARGUMENTS, MAX_REPLY, MAX_TOOL_CALLS, ToolCall

WAVE = ToolCall("c1", "gesture", '{"name": "wave"}')
BAD = ToolCall("c2", "where", "[")


def told(history: History) -> list[tuple[str, Any]]:
    return [(each["role"], each["content"]) for each in history.messages("rules")]


def test_turns_and_replies_are_told_behind_the_instructions() -> None:
    history = History()
    history.begin_turn("hello")
    history.add_said("Hello!")
    history.add_said("Who are you?")
    history.begin_turn("Ann")
    assert told(history) == [
        ("system", "rules"),
        ("user", "hello"),
        ("assistant", "Hello! Who are you?"),
        ("user", "Ann"),
    ]
    history.forget_turns()
    assert told(history) == [("system", "rules")]
    history.cut("")


def test_calls_stand_beside_their_results() -> None:
    history = History()
    history.begin_turn("wave")
    history.add_calls((WAVE, BAD))
    history.add_result(BAD, "no")
    history.add_result(WAVE, "x" * (MAX_RESULT + 1))
    history.go_on()
    history.add_said("I waved.")
    _, _, asked, first, second, last = history.messages("rules")
    assert asked["content"] is None
    assert [each["function"] for each in asked["tool_calls"]] == [
        {"name": "gesture", "arguments": '{"name": "wave"}'},
        {"name": "where", "arguments": "{}"},
    ]
    assert (first["tool_call_id"], first["content"]) == ("c1", "x" * MAX_RESULT + " ...")
    assert (second["tool_call_id"], second["content"]) == ("c2", "no")
    assert last == {"role": "assistant", "content": "I waved."}


def test_a_call_that_was_interrupted_has_a_result() -> None:
    history = History()
    history.begin_turn("wave")
    history.add_said("I wave.")
    history.add_calls((WAVE,))
    history.cut("I wave.")
    assert told(history)[2:] == [
        ("assistant", "I wave."),
        ("tool", "It was not run to its end: the visitor has interrupted."),
    ]


@pytest.mark.parametrize(
    ("heard", "kept"),
    [
        ("", []),
        ("One", ["One ..."]),
        ("One two.", ["One two. ..."]),
        ("One two.  Three", ["One two. Three ..."]),
        ("One two. Three.", ["One two. Three."]),
        ("One two. Three. Fo", ["One two. Three.", "Fo ..."]),
        ("One two. Three. Four. And more than was said", ["One two. Three.", "Four."]),
    ],
)
def test_of_an_interrupted_answer_what_was_heard_is_told(heard: str, kept: list[str]) -> None:
    history = History()
    history.begin_turn("count")
    history.add_said("One two.")
    history.add_said("Three.")
    history.go_on()
    history.add_said("Four.")
    history.cut(heard)
    assert [content for role, content in told(history) if role == "assistant"] == kept


def test_what_was_not_answered_is_joined_with_what_follows() -> None:
    history = History()
    history.begin_turn("hello")
    history.begin_turn("are you there?")
    assert told(history)[1:] == [("user", "hello\nare you there?")]


def test_only_so_many_turns_are_told() -> None:
    history = History()
    for number in range(MAX_TURNS + 3):
        history.begin_turn(f"question {number}")
        history.add_said(f"Answer {number}.")
    assert len(told(history)) == 1 + 2 * MAX_TURNS
    assert told(history)[1] == ("user", "question 3")


def test_only_so_many_characters_are_told_of_older_turns() -> None:
    history = History()
    for _ in range(4):
        history.begin_turn("x" * (MAX_HISTORY // 3))
        history.add_calls((WAVE,))
    assert len(history.messages("rules")) == 1 + 3 * 2
    history.begin_turn("x" * (MAX_HISTORY * 2))
    history.go_on()
    assert [len(content) for _, content in told(history)[1:]] == [MAX_HISTORY * 2]


def results(history: History) -> list[str]:
    return [content for role, content in told(history) if role == "tool"]


def test_of_what_tools_told_in_a_turn_the_oldest_is_left_out() -> None:
    history = History()
    history.begin_turn("look around")
    for number in range(8):
        call = ToolCall(f"c{number}", "where", json.dumps({"what": "x" * 500}))
        history.add_said(f"Look {number}.")
        history.add_calls((call,))
        history.add_result(call, str(number) * MAX_RESULT)
        history.go_on()
    found = results(history)
    assert found[:3] == ["Left out: there was too much of it."] * 3
    assert [each[0] for each in found[3:]] == ["3", "4", "5", "6", "7"]
    assert sum(len(json.dumps(each)) for each in history.messages("")) < MAX_HISTORY + 2_000
    assert [content for role, content in told(history) if role == "assistant"] == [f"Look {n}." for n in range(8)]


def test_a_turn_that_grows_leaves_out_older_turns_first() -> None:
    history = History()
    history.begin_turn("x" * (MAX_HISTORY // 2))
    history.begin_turn("and now?")
    for number in range(4):
        call = ToolCall(f"c{number}", "where")
        history.add_calls((call,))
        history.add_result(call, "y" * MAX_RESULT)
        history.go_on()
    assert [content for role, content in told(history) if role == "user"] == ["and now?"]
    assert [len(each) for each in results(history)] == [MAX_RESULT] * 4


def test_replies_of_a_server_that_means_harm_are_told_without_their_calls() -> None:
    history = History()
    history.begin_turn("hello")
    for number in range(MAX_ROUNDS - 1):
        harm = [ToolCall(f"{number}-{each:0197}", "w" * 64, "x" * MAX_ARGUMENTS) for each in range(MAX_TOOL_CALLS)]
        history.add_said("s" * MAX_REPLY)
        history.add_calls(harm)
        for call in harm:
            history.add_result(call, "y" * MAX_RESULT)
        history.go_on()
        assert sum(len(json.dumps(each)) for each in history.messages("")) < MAX_HISTORY * 1.5
    assert sum(len(content or "") for _, content in told(history)) <= MAX_HISTORY


def test_the_newest_picture_is_told_in_its_turn_alone() -> None:
    history = History()
    history.begin_turn("what do you see?")
    for name in ("old", "new"):
        history.add_calls((ToolCall(name, "look"),))
        history.add_result(ToolCall(name, "look"), "a picture")
        history.add_picture(ToolCall(name, "look"), f"data:{name}")
        history.go_on()
    pictures = [content for role, content in told(history) if isinstance(content, list)]
    assert len(pictures) == 1
    warning, picture = pictures[0]
    assert warning["text"].startswith("UNTRUSTED")
    assert picture == {"type": "image_url", "image_url": {"url": "data:new"}}
    history.begin_turn("and now?")
    assert "data:" not in json.dumps(history.messages("rules"))


def test_a_picture_that_is_withheld_is_not_told_and_that_is_said() -> None:
    history = History()
    history.begin_turn("what do you see?")
    history.add_calls((ToolCall("c1", "look"), WAVE))
    history.add_result(ToolCall("c1", "look"), "a picture")
    history.add_picture(ToolCall("c1", "look"), "data:x")
    history.go_on()
    history.withhold_pictures()
    assert "data:" not in json.dumps(history.messages("rules"))
    assert ("tool", "The picture is not shown: a visitor is here who does not consent to that.") in told(history)


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("begin_turn"), st.text(max_size=20)),
        st.tuples(st.just("add_said"), st.text(max_size=20)),
        st.tuples(st.just("add_calls"), st.integers(0, 3)),
        st.tuples(st.just("add_result"), st.integers(0, 3)),
        st.tuples(st.just("go_on"), st.none()),
        st.tuples(st.just("cut"), st.text(max_size=20)),
        st.tuples(st.just("add_picture"), st.integers(0, 3)),
        st.tuples(st.just("withhold_pictures"), st.none()),
    ),
    max_size=40,
)


@given(STEPS)
def test_whatever_happens_each_call_has_one_result_directly_behind_it(steps: list[tuple[str, Any]]) -> None:
    history = History()
    history.begin_turn("hello")
    for number, (name, value) in enumerate(steps):
        match name:
            case "add_calls":
                history.add_calls([ToolCall(f"{number}-{each}", "where") for each in range(value)])
            case "add_result":
                history.add_result(ToolCall(f"{number}-{value}", "where"), "done")
            case "add_picture":
                history.add_picture(ToolCall(f"{number}-{value}", "look"), "data:x")
            case "go_on" | "withhold_pictures":
                getattr(history, name)()
            case _:
                getattr(history, name)(value)
        wanted: list[str] = []
        for message in history.messages("rules"):
            if message["role"] == "tool":
                assert message["tool_call_id"] == wanted.pop(0)
            else:
                assert not wanted
                wanted = [each["id"] for each in message.get("tool_calls", ())]
                assert message["role"] != "assistant" or message["content"] or wanted
        assert not wanted
