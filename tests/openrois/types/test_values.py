"""Values are text; the profile's type says which text."""

import math
from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from openrois.types.codes import ComponentStatus, ReturnCode, StreamStatus
from openrois.types.values import check_value, date_time, decode_value, encode_value, read_date_time

FITS = [
    ("int", "0"),
    ("Integer", "-17"),
    ("long", "-0"),
    ("int", "007"),
    ("short", "9" * 20),
    ("double", "1"),
    ("FLOAT", "-1.5e-3"),
    ("double", "1e308"),
    ("bool", "true"),
    ("Boolean", "false"),
    ("Component_Status", "BUSY"),
    ("string", ""),
    ("Stream_Status", "anything"),
    ("DateTime", "yesterday"),
    ("string[]", '["a", "b"]'),
    ("RoISIdentifier[]", "[]"),
    ("int[]", "[1, -2]"),
    ("double[]", "[1, 2.5, -1e-3]"),
    ("bool[]", "[true, false]"),
    ("Component_Status[]", '["READY"]'),
    ("int[][]", "[[1],[2,3],[]]"),
    ("string[][][][][][][][]", '[[[[[[[["a"]]]]]]]]'),
]

MISFITS = [
    ("int", ""),
    ("int", "+5"),
    ("int", "0x5"),
    ("int", "1_0"),
    ("int", "1.0"),
    ("int", " 1"),
    ("int", "1\n"),
    ("int", "٣"),
    ("int", "9" * 21),
    ("double", "nan"),
    ("double", "1."),
    ("double", ".5"),
    ("double", "1e"),
    ("double", "1e309"),
    ("double", "٣.٣"),
    ("bool", "True"),
    ("bool", "1"),
    ("Component_Status", "ready"),
    ("Component_Status", "1"),
    ("string[]", "a"),
    ("string[]", '"a"'),
    ("string[]", '{"a":1}'),
    ("string[]", "[1]"),
    ("string[]", '["a",]'),
    ("string[]", "[" * 20_000),
    ("int[]", '["1"]'),
    ("int[]", "[1.0]"),
    ("int[]", "[true]"),
    ("int[]", "[" + "9" * 21 + "]"),
    ("int[]", "[" + "9" * 5000 + "]"),
    ("double[]", "[NaN]"),
    ("double[]", "[1e999]"),
    ("double[]", "[" + "9" * 400 + "]"),
    ("double[]", "[true]"),
    ("bool[]", "[1]"),
    ("Component_Status[]", '["ready"]'),
    ("int[][]", "[1]"),
    ("int[][]", "[[1],2]"),
    ("string" + "[]" * 9, "[" * 9 + "]" * 9),
]


@pytest.mark.parametrize(("type_code", "value"), FITS)
def test_what_fits(type_code: str, value: str) -> None:
    check_value(type_code, value)


@pytest.mark.parametrize(("type_code", "value"), MISFITS, ids=lambda text: text[:20])
def test_what_does_not(type_code: str, value: str) -> None:
    with pytest.raises(ValueError) as raised:
        check_value(type_code, value)
    assert len(str(raised.value)) < 200


def test_a_written_list_reads_back() -> None:
    items = ["nod", 'say "hi"', "お辞儀"]
    assert decode_value("RoISIdentifier[]", encode_value("RoISIdentifier[]", items)) == items


def test_a_date_time_is_utc() -> None:
    assert date_time(0) == "1970-01-01T00:00:00.000000+00:00"
    assert datetime.fromisoformat(date_time(1_700_000_000.25)).timestamp() == 1_700_000_000.25


WRITTEN: list[tuple[str, Any, str]] = [
    ("int", 5, "5"),
    ("INTEGER", -(10**20) + 1, "-" + "9" * 20),
    ("double", 0.1, "0.1"),
    ("float", 1e-7, "1e-07"),
    ("double", 1.7976931348623157e308, "1.7976931348623157e+308"),
    ("double", 2, "2"),
    ("bool", True, "true"),
    ("Boolean", False, "false"),
    ("string", 'say "hi"', 'say "hi"'),
    ("DateTime", datetime(2026, 6, 1, 12, tzinfo=UTC), "2026-06-01T12:00:00+00:00"),
    ("DateTime", "whatever", "whatever"),
    ("Component_Status", ComponentStatus.BUSY, "BUSY"),
    ("component_status", "READY", "READY"),
    ("Stream_Status", StreamStatus.STREAMING_RUNNING, "STREAMING_RUNNING"),
    ("RoISIdentifier[]", ("a", "お辞儀"), '["a", "お辞儀"]'),
    ("int[]", [], "[]"),
    ("int[][]", ((1,), [2, 3]), "[[1], [2, 3]]"),
    ("Component_Status[]", [ComponentStatus.ERROR], '["ERROR"]'),
    ("DateTime[]", [datetime(2026, 6, 1, tzinfo=UTC)], '["2026-06-01T00:00:00+00:00"]'),
]

UNWRITABLE: list[tuple[str, Any]] = [
    ("double", math.nan),
    ("double", math.inf),
    ("double[]", [1.0, -math.inf]),
    ("int", 10**20),
    ("int[]", [10**20]),
    ("int", -(10**5000)),
    ("double", 10**20),
    ("int", 1.0),
    ("int", True),
    ("int", "5"),
    ("double", "0.5"),
    ("bool", 1),
    ("bool", "true"),
    ("string", 5),
    ("string", None),
    ("string", ["a"]),
    ("string", b"a"),
    ("DateTime", 0),
    ("Component_Status", "ready"),
    ("Component_Status", ReturnCode.OK),
    ("Component_Status", StreamStatus.STREAMING_RUNNING),
    ("Component_Status[]", ["READY", "OK"]),
    ("Stream_Status", "RUNNING"),
    ("Stream_Status", ComponentStatus.READY),
    ("Stream_Status", 2),
    ("string[]", "a"),
    ("string[]", {"a"}),
    ("string[]", [1]),
    ("int[][]", [1]),
    ("string" + "[]" * 9, [[[[[[[[["a"]]]]]]]]]),
]


@pytest.mark.parametrize(("type_code", "value", "text"), WRITTEN)
def test_what_is_written(type_code: str, value: Any, text: str) -> None:
    assert encode_value(type_code, value) == text
    check_value(type_code, text)


@pytest.mark.parametrize(("type_code", "value"), UNWRITABLE, ids=range(len(UNWRITABLE)))
def test_what_cannot_be_written(type_code: str, value: Any) -> None:
    with pytest.raises(ValueError) as raised:
        encode_value(type_code, value)
    assert len(str(raised.value)) < 200


@pytest.mark.parametrize(
    ("type_code", "text", "value"),
    [
        ("int", "-0", 0),
        ("Long", "17", 17),
        ("double", "1e3", 1000.0),
        ("double", "7", 7.0),
        ("bool", "true", True),
        ("boolean", "false", False),
        ("string", "true", "true"),
        ("Component_Status", "BUSY", "BUSY"),
        ("Stream_Status", "whatever", "whatever"),
        ("DateTime", "whatever", "whatever"),
        ("int[]", "[1, 2]", [1, 2]),
        ("String[][]", '[["a"], []]', [["a"], []]),
    ],
)
def test_what_is_read(type_code: str, text: str, value: Any) -> None:
    read = decode_value(type_code, text)
    assert (read, type(read)) == (value, type(value))


@pytest.mark.parametrize(("type_code", "value"), MISFITS, ids=lambda text: text[:20])
def test_what_cannot_be_read(type_code: str, value: str) -> None:
    with pytest.raises(ValueError):
        decode_value(type_code, value)


@pytest.mark.parametrize(
    "text",
    ["2026-06-01T12:00:00+00:00", "2026-06-01T12:00:00Z", "20260601T120000Z", "2026-06-01T21:00:00.000+09:00"],
)
def test_date_times_of_iso_8601(text: str) -> None:
    assert read_date_time(text) == datetime(2026, 6, 1, 12, tzinfo=UTC)


def test_a_date_time_without_an_offset_has_no_zone() -> None:
    assert read_date_time("2026-06-01T12:00").tzinfo is None


@pytest.mark.parametrize("text", ["", "noon", "1780315200", "2026-06-01", "20260601", "2026-13-01T12:00", "1" * 5000])
def test_what_is_no_date_time(text: str) -> None:
    with pytest.raises(ValueError, match="is no date and time of ISO 8601") as raised:
        read_date_time(text)
    assert len(str(raised.value)) < 200


values = st.one_of(
    st.tuples(st.just("int"), st.integers(-(10**20) + 1, 10**20 - 1)),
    st.tuples(st.just("double"), st.floats(allow_nan=False, allow_infinity=False)),
    st.tuples(st.just("bool"), st.booleans()),
    st.tuples(st.just("string"), st.text()),
    st.tuples(st.just("Component_Status"), st.sampled_from(ComponentStatus)),
    st.tuples(st.just("int[][]"), st.lists(st.lists(st.integers(-(10**19), 10**19)))),
    st.tuples(st.just("double[]"), st.lists(st.floats(allow_nan=False, allow_infinity=False))),
    st.tuples(st.just("string[]"), st.lists(st.text())),
)


@settings(deadline=None)
@given(values)
def test_what_is_written_is_read_back(typed: tuple[str, Any]) -> None:
    type_code, value = typed
    assert decode_value(type_code, encode_value(type_code, value)) == value
