"""Conditions: any text is read or refused; what is written is read back; LIKE agrees with a plain matcher."""

import re
from contextlib import suppress

from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.engine.condition import Comparison, parse_condition
from openrois.errors import BadParameter

PROPERTIES = frozenset({"component_ref", "component_type"})
words = st.sampled_from(
    ["component_ref", "component_type", '"component_ref"', "=", "LIKE", "AND", "'", "''", "'a'", " ", "%"]
)


@settings(max_examples=50)
@given(st.text() | st.lists(words, max_size=12).map(" ".join) | st.lists(words, max_size=12).map("".join))
def test_any_text(text: str) -> None:
    with suppress(BadParameter):
        condition = parse_condition(text, PROPERTIES)
        assert all(comparison.property in PROPERTIES for comparison in condition.comparisons)
        condition.matches({"component_ref": text})


@settings(max_examples=35)
@given(st.lists(st.tuples(st.sampled_from(sorted(PROPERTIES)), st.booleans(), st.text(max_size=20)), max_size=4))
def test_what_is_written_is_read_back(parts: list[tuple[str, bool, str]]) -> None:
    comparisons = tuple(Comparison(*part) for part in parts)
    text = " AND ".join(
        f"{c.property} {'LIKE' if c.pattern else '='} '" + c.text.replace("'", "''") + "'" for c in comparisons
    )
    assert parse_condition(text, PROPERTIES).comparisons == comparisons


def expression(pattern: str) -> str:
    """Return the regular expression that a LIKE pattern stands for."""
    out, escaped = [], False
    for character in pattern:
        if not escaped and character == "\\":
            escaped = True
            continue
        special = {"%": ".*", "_": "."}.get(character) if not escaped else None
        out.append(special or re.escape(character))
        escaped = False
    return "".join(out) + (re.escape("\\") if escaped else "")


@settings(max_examples=70)
@given(st.text(alphabet="ab%_\\", max_size=8), st.text(alphabet="ab%_\\", max_size=8))
def test_like_is_what_a_plain_matcher_says(pattern: str, value: str) -> None:
    expected = re.fullmatch(expression(pattern), value, re.DOTALL) is not None
    assert Comparison("component_ref", True, pattern).matches(value) is expected
