"""Values are text; the profile's type says which text."""

import json
from datetime import datetime

import pytest

from openrois.types.values import check_value, date_time, encode_list

FITS = [
    ("int", "0"),
    ("Integer", "-17"),
    ("long", "-0"),
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
    check_value("RoISIdentifier[]", encode_list(items))
    assert json.loads(encode_list(items)) == items


def test_a_date_time_is_utc() -> None:
    assert date_time(0) == "1970-01-01T00:00:00.000000+00:00"
    assert datetime.fromisoformat(date_time(1_700_000_000.25)).timestamp() == 1_700_000_000.25
