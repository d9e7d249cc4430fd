"""The interface definition language of ROS: what is read, and what is said of texts that are none."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_robots.ros2.interfaces.definitions import (
    MAX_TEXT,
    PRIMITIVES,
    Array,
    Constant,
    DefinitionError,
    Field,
    FieldType,
    parse_action,
    parse_message,
    parse_service,
)
from openrois_robots.ros2.interfaces.derived import action_messages

NAME = "kit_msgs/msg/Kit"


@pytest.mark.parametrize(
    ("line", "field"),
    [
        ("int32 x", Field(FieldType("int32"), "x")),
        ("  uint8   x  # how many", Field(FieldType("uint8"), "x")),
        ("float64[36] c", Field(FieldType("float64", None, Array(36, True)), "c")),
        ("string[] names", Field(FieldType("string", None, Array()), "names")),
        ("int8[<=5] few", Field(FieldType("int8", None, Array(5)), "few")),
        ("string<=10 short", Field(FieldType("string", 10), "short")),
        ("string<=10[<=3] shorts", Field(FieldType("string", 10, Array(3)), "shorts")),
        ("Other other", Field(FieldType("kit_msgs/msg/Other"), "other")),
        ("std_msgs/Header header", Field(FieldType("std_msgs/msg/Header"), "header")),
        ("std_msgs/msg/Header header", Field(FieldType("std_msgs/msg/Header"), "header")),
        ("float64 w 1", Field(FieldType("float64"), "w", 1.0)),
        ("float32 w -2.5e1", Field(FieldType("float32"), "w", -25.0)),
        ("bool on true", Field(FieldType("bool"), "on", True)),
        ("bool on 0", Field(FieldType("bool"), "on", False)),
        ("uint8 mask 0xff", Field(FieldType("uint8"), "mask", 255)),
        ("int8 low -128", Field(FieldType("int8"), "low", -128)),
        ("string s 'a # b'  # said", Field(FieldType("string"), "s", "a # b")),
        ('string s "it\\"s"', Field(FieldType("string"), "s", 'it"s')),
        ("int32[] some [1, -2]", Field(FieldType("int32", None, Array()), "some", (1, -2))),
        ("int32[] none []", Field(FieldType("int32", None, Array()), "none", ())),
        ("int32[2] two [1, 2]", Field(FieldType("int32", None, Array(2, True)), "two", (1, 2))),
        ("string[] s ['a', \"b\"]", Field(FieldType("string", None, Array()), "s", ("a", "b"))),
    ],
)
def test_a_field_is_read(line: str, field: Field) -> None:
    assert parse_message(NAME, f"# a kit\n\n{line}\n").fields == (field,)


@pytest.mark.parametrize(
    ("line", "constant"),
    [
        ("uint8 STATUS_OK=1", Constant(FieldType("uint8"), "STATUS_OK", 1)),
        ("uint8 A = 2 # two", Constant(FieldType("uint8"), "A", 2)),
        ("float64 PI=3.5", Constant(FieldType("float64"), "PI", 3.5)),
        ("string NAME= plain # text ", Constant(FieldType("string"), "NAME", "plain # text")),
        ("string NAME='quoted'", Constant(FieldType("string"), "NAME", "quoted")),
        ("bool ON=True", Constant(FieldType("bool"), "ON", True)),
    ],
)
def test_a_constant_is_read(line: str, constant: Constant) -> None:
    read = parse_message(NAME, line)
    assert read.constants == (constant,)
    assert read.fields == ()


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("int32", "expected a type and a name"),
        ("int33 x", "int33 is no type"),
        ("wstring x", "wstring is no type"),
        ("int32[ x", r"int32\[ is no type"),
        ("int32<=4 x", "only a string may have a bound"),
        ("string<=0 x", "only a string may have a bound, of 1 to 65536"),
        ("int32[0] x", "an array must have 1 to 65536 items"),
        ("int32[99999999] x", "an array must have 1 to 65536 items"),
        ("int32[<=] x", "a bound is missing behind <="),
        ("int32 X", "the field X must be in lower case"),
        ("int32 a__b", "the field a__b must be in lower case, with single _"),
        ("int32 a=1", "the constant a must be in upper case"),
        ("int32[] A=1", "a constant must be of a primitive type"),
        ("Other A=1", "a constant must be of a primitive type"),
        ("uint8 A=256", "256 is no uint8"),
        ("uint8 A=one", "one is no integer"),
        ("uint8 a -1", "-1 is no uint8"),
        ("float32 a nan", "nan is no number"),
        ("float32 a 1e999", "1e999 is no number"),
        ("bool a maybe", "maybe is neither true nor false"),
        ("string a b", "the default of a string must be quoted"),
        ("string[] a [b]", "the strings of a default must be quoted"),
        ("Other a 1", "a message can have no default"),
        ("int32[] a 1", r"the default of an array must stand in \[ \]"),
        ("int32[2] a [1]", "the default must have 2 items, not 1"),
        ("int32[<=1] a [1, 2]", "the default must have 1 items, not 2"),
        ("int32 a\nint8 a", "a stands there twice"),
    ],
)
def test_a_line_that_is_none_is_said(line: str, said: str) -> None:
    with pytest.raises(DefinitionError, match=f"^{NAME}: .*{said}"):
        parse_message(NAME, line)


def test_a_text_that_is_too_long_is_refused() -> None:
    with pytest.raises(DefinitionError, match="has more than 100000 characters"):
        parse_message(NAME, "#" * (MAX_TEXT + 1))


def test_a_service_has_two_parts() -> None:
    service = parse_service("kit_msgs/srv/Say", "string text\n---\nbool success\n")
    assert (service.request.name, service.response.name) == ("kit_msgs/srv/Say_Request", "kit_msgs/srv/Say_Response")
    assert [each.name for each in (*service.request.fields, *service.response.fields)] == ["text", "success"]
    with pytest.raises(DefinitionError, match="expected 2 parts with a line --- between them, not 1"):
        parse_service("kit_msgs/srv/Say", "string text")


def test_an_action_has_three_parts_and_its_services_and_feedback_follow_from_it() -> None:
    action = parse_action("kit_msgs/action/Go", "float64 x\n---\nKit kit\n---\nfloat64 left\n")
    derived = action_messages(action)
    assert derived.send_goal.request.name == "kit_msgs/action/Go_SendGoal_Request"
    assert [each.type.name for each in derived.send_goal.request.fields] == [
        "unique_identifier_msgs/msg/UUID",
        "kit_msgs/action/Go_Goal",
    ]
    assert [each.name for each in derived.send_goal.response.fields] == ["accepted", "stamp"]
    assert [each.name for each in derived.get_result.request.fields] == ["goal_id"]
    assert [each.type.name for each in derived.get_result.response.fields] == ["int8", "kit_msgs/action/Go_Result"]
    assert derived.feedback.name == "kit_msgs/action/Go_FeedbackMessage"
    assert action.result.fields[0].type.name == "kit_msgs/msg/Kit"
    with pytest.raises(DefinitionError, match="expected 3 parts"):
        parse_action("kit_msgs/action/Go", "---\n")


LINES = st.lists(
    st.one_of(
        st.text("#=<>[]'\"\\/ -.,_x09AZaz\n\t", max_size=40),
        st.tuples(
            st.sampled_from(sorted(PRIMITIVES)),
            st.sampled_from(["", "[]", "[3]", "[<=2]", "<=4"]),
            st.sampled_from(["x", "X", "a_b", "__"]),
            st.sampled_from(["", " 1", "=1", " [1]", " 'a'", "='", ' "\\', " # c"]),
        ).map(lambda parts: f"{parts[0]}{parts[1]} {parts[2]}{parts[3]}"),
    ),
    max_size=8,
).map("\n".join)


@given(LINES)
def test_any_text_is_a_definition_or_is_said_to_be_none(text: str) -> None:
    cases: tuple[tuple[Callable[[str, str], object], str], ...] = (
        (parse_message, NAME),
        (parse_service, "k/srv/K"),
        (parse_action, "k/action/K"),
    )
    for parse, name in cases:
        said = f"{name}: "
        try:
            parse(name, text)
        except DefinitionError as error:
            said = str(error)
        assert said.startswith(name)


@given(st.text(max_size=300))
def test_arbitrary_text_is_read_or_refused(text: str) -> None:
    try:
        read = parse_message(NAME, text)
    except DefinitionError:
        return
    names = [*(each.name for each in read.fields), *(each.name for each in read.constants)]
    assert len(set(names)) == len(names)
