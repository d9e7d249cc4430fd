"""Conditions: what can be read, what matches, and what does not cost time."""

import re
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.engine import condition
from openrois.engine.condition import Comparison, Condition, parse_condition
from openrois.errors import BadParameter
from tests.support.steps import lines_run

PROPERTIES = frozenset({"component_ref", "component_type", "a:b.c_1"})
LAMP = {"component_ref": "robot/lamp", "component_type": "urn:x-rois:def:component:Test::Lamp"}


def matches(text: str, value: str = "robot/lamp") -> bool:
    return parse_condition(text, PROPERTIES).matches({**LAMP, "component_ref": value})


@pytest.mark.parametrize("text", ["", " ", "\t\n "])
def test_nothing_matches_everything(text: str) -> None:
    assert parse_condition(text, PROPERTIES) == Condition()
    assert matches(text)


@pytest.mark.parametrize(
    "text",
    [
        "component_ref = 'robot/lamp'",
        "component_ref='robot/lamp'",
        "  component_ref\n=\t'robot/lamp'  ",
        "\"component_ref\" = 'robot/lamp'",
        "component_ref LIKE 'robot/%'",
        "component_ref like '%lamp'",
        "component_ref LiKe'robot_lamp'",
        "component_ref = 'robot/lamp' AND component_type LIKE '%::Lamp'",
        "component_ref = 'robot/lamp'and component_ref LIKE '%'AND component_ref LIKE 'r%'",
    ],
)
def test_what_matches(text: str) -> None:
    assert matches(text)


@pytest.mark.parametrize(
    "text",
    [
        "component_ref = 'Robot/lamp'",
        "component_ref = 'robot/%'",
        "component_ref = ''",
        "component_ref LIKE 'ROBOT%'",
        "component_ref = 'robot/lamp' AND component_type = 'urn'",
        "\"a:b.c_1\" = 'absent'",
        "a:b.c_1 LIKE '%'",
    ],
)
def test_what_does_not_match(text: str) -> None:
    assert not matches(text)


@pytest.mark.parametrize(
    "text",
    [
        "component_ref",
        "component_ref =",
        "= 'x'",
        "component_ref = x",
        'component_ref = "x"',
        "component_ref = 5",
        "component_ref == 'x'",
        "component_ref <> 'x'",
        "component_ref IS 'x'",
        "component_ref LIKE",
        "component_ref 'x'",
        "component_ref = 'x",
        "component_ref = 'it''s",
        "component_ref = 'a''b'c'",
        "component_ref = 'x' OR component_ref = 'y'",
        "component_ref = 'x' AND",
        "component_ref = 'x' component_ref = 'y'",
        "AND component_ref = 'x'",
        "NOT component_ref = 'x'",
        "(component_ref = 'x')",
        "unknown = 'x'",
        "Component_Ref = 'x'",
        "'component_ref' = 'x'",
        '"component_ref = ' + "'x'",
        "component_ref = 'x';",
        "component_ref = 'x'\0",
        "\uff43omponent_ref = 'x'",
        "component_ref" + " " * 5000 + "= 'x'",
    ],
)
def test_what_cannot_be_read(text: str) -> None:
    with pytest.raises(BadParameter):
        parse_condition(text, PROPERTIES)


def test_quotes_are_doubled() -> None:
    read = parse_condition("component_ref = 'it''s ''here'''", PROPERTIES)
    assert read.comparisons == (Comparison("component_ref", False, "it's 'here'"),)
    assert matches("component_ref LIKE 'it''s%'", "it's")


@pytest.mark.parametrize(
    ("pattern", "value", "expected"),
    [
        ("", "", True),
        ("", "a", False),
        ("%", "", True),
        ("%%", "abc", True),
        ("_", "", False),
        ("_", "a", True),
        ("_", "ab", False),
        ("a%b%c", "a--b--c", True),
        ("a%b%c", "a--b--", False),
        ("%ab", "aab", True),
        ("%a_b", "xaxab_acb", True),
        ("abc%", "ab", False),
        ("abc", "abd", False),
        (r"100\%", "100%", True),
        (r"100\%", "1000", False),
        (r"a\_b", "a_b", True),
        (r"a\_b", "axb", False),
        (r"a\\b", r"a\b", True),
        (r"a\x", "ax", True),
        ("a\\", "a\\", True),
        ("%\\", "ab", False),
        ("日%", "日本", True),
    ],
)
def test_like(pattern: str, value: str, expected: bool) -> None:
    assert Comparison("p", True, pattern).matches(value) is expected


def walked(pattern: str, value: str) -> bool:
    """LIKE as it is defined, by trying everything."""
    if not pattern:
        return not value
    if pattern[0] == "%":
        return any(walked(pattern[1:], value[at:]) for at in range(len(value) + 1))
    if pattern[0] == "\\":
        literal, rest = (pattern[1], pattern[2:]) if len(pattern) > 1 else ("\\", "")
        return value[:1] == literal and walked(rest, value[1:])
    return bool(value) and pattern[0] in ("_", value[0]) and walked(pattern[1:], value[1:])


@given(pattern=st.text("%_\\ab.\n", max_size=8), value=st.text("ab.%_\\\n", max_size=8))
@settings(max_examples=500)
def test_like_is_what_it_is_defined_to_be(pattern: str, value: str) -> None:
    assert Comparison("p", True, pattern).matches(value) is walked(pattern, value)


def test_a_pattern_is_read_once_however_many_components_there_are() -> None:
    """A viewer's conditions of 4 KiB took 16 ms each with seventeen components, and a second with a thousand."""
    read = parse_condition(" AND ".join(["component_ref LIKE '%r_b%'"] * 100), PROPERTIES)
    lines = lines_run(lambda: read.matches(LAMP), condition)
    assert lines <= 10 * 100


def refused(text: str) -> None:
    with pytest.raises(BadParameter):
        parse_condition(text, PROPERTIES)


@pytest.mark.parametrize(
    "written",
    [
        lambda n: "component_ref = '" + "''" * n,
        lambda n: "component_ref = '" + "a" * n,
        lambda n: " AND ".join(["component_ref = 'a'"] * n) + " AND",
        lambda n: "component_ref" + " " * n,
        lambda n: "component_ref = 'a' " + "a" * n,
        lambda n: '"' + "a" * n,
    ],
)
def test_reading_takes_time_linear_in_the_condition(written: Callable[[int], str]) -> None:
    few, many = (lines_run(lambda n=n: refused(written(n)), condition) for n in (80, 160))  # type: ignore[misc]
    assert 0 < few <= many <= 2 * few + 20


def test_a_token_is_read_without_going_back() -> None:
    repetitions = re.findall(r"(?<!\\)[*+?{][+]?", re.sub(r"\(\?(?:P<\w+>|:)", "(", condition._TOKEN.pattern))
    assert repetitions
    assert set(repetitions) == {"*+"}


@pytest.mark.parametrize(
    ("pattern", "value"),
    [
        (lambda n: "%a" * n + "b", lambda n: "a" * n),
        (lambda n: "%" * n + "b", lambda n: "a" * n),
        (lambda n: "%" + "a" * n + "b", lambda n: "a" * n * 2),
        (lambda n: "a%" * n + "c", lambda n: "ab" * n),
        (lambda n: "_%" * n + "c", lambda n: "ab" * n),
    ],
)
def test_a_pattern_costs_at_most_its_length_times_the_text(
    pattern: Callable[[int], str], value: Callable[[int], str]
) -> None:
    for n in (10, 20, 40, 80):
        comparison, text = Comparison("p", True, pattern(n)), value(n)
        assert not comparison.matches(text)
        lines = lines_run(lambda comparison=comparison, text=text: comparison.matches(text), condition)  # type: ignore[misc]
        assert lines <= 8 * (len(comparison.text) + 1) * (len(text) + 1)


def test_a_pattern_that_matches_at_once_costs_no_more_than_both_lengths() -> None:
    lines = [lines_run(lambda n=n: Comparison("p", True, "ab%" * n).matches("ab" * n), condition) for n in (50, 100)]  # type: ignore[misc]
    assert lines[1] <= 2 * lines[0]


def test_what_a_property_must_equal() -> None:
    read = parse_condition(
        "component_ref LIKE 'r%' AND component_ref = 'robot/lamp' AND component_type = 'urn'", PROPERTIES
    )
    assert read.value_of("component_ref") == "robot/lamp"
    assert read.value_of("a:b.c_1") is None
    rest = read.without("component_ref", "a:b.c_1")
    assert rest.comparisons == (Comparison("component_type", False, "urn"),)
