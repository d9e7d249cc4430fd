"""Texts of values for the corpus: what each type reads, and as what; and what it refuses. Pure."""

import json
from collections.abc import Iterator, Mapping
from typing import Any, Final

__all__ = ["emit"]

_INTEGERS: Final[Mapping[str, int]] = {
    "0": 0,
    "-0": 0,
    "7": 7,
    "-7": -7,
    "007": 7,
    "2147483647": 2**31 - 1,
    "-2147483648": -(2**31),
    "9007199254740991": 2**53 - 1,
    "-9007199254740991": -(2**53) + 1,
}
_NUMBERS: Final[Mapping[str, float]] = {
    "0": 0.0,
    "1.5": 1.5,
    "-0.25": -0.25,
    "1e3": 1000.0,
    "2.5E-2": 0.025,
    "1e+2": 100.0,
}
_TRUTHS: Final[Mapping[str, bool]] = {"true": True, "false": False}
_TEXTS: Final = ("", "x", " x ", "7", "true", "null", "こんにちは", "👩‍🚀", 'a "quoted" word', "1.0,2.0,0.5", '["a"]')

_NO_NUMBERS: Final = (
    "",
    " 7",
    "7 ",
    "+7",
    "x",
    "0x10",
    "1_000",
    "7,5",
    "\u0667",
    "\uff17",
    "NaN",
    "Infinity",
    "-",
    "true",
    '"7"',
    "[]",
)
_NO_INTEGERS: Final = (*_NO_NUMBERS, "7.0", "7.5", "1e3", "1" * 21, "1" * 5000)
_NO_TRUTHS: Final = ("", "True", "FALSE", "1", "0", "yes", " true", '"true"')
_NO_STATUS: Final = ("", "ready", "READY ", "0", "FINE")
_NO_LISTS: Final = ("", "a", "a,b", "{}", '"a"', "null", "[", '["a"', "['a']", "1")

_LISTS: Final[Mapping[str, tuple[str, ...]]] = {
    "string[]": ("[]", '["a", "b"]', '["", "✓", "\\ud83e\\udd16"]', ' [ "a" ] '),
    "RoISIdentifier[]": ('["robot/1"]',),
    "String[]": ('["1.0,2.0,0.5"]',),
    "int[]": ("[]", "[1, -2, 0]", "[9007199254740991]"),
    "double[]": ("[1, 1.5, -2e3]",),
    "bool[]": ("[true, false]",),
    "Component_Status[]": ('["READY", "BUSY"]',),
    "int[][]": ("[[1], [], [2, 3]]",),
}
_WRONG_LISTS: Final[Mapping[str, tuple[str, ...]]] = {
    "string[]": ("[1]", "[null]", '["a", null]', '[["a"]]', "[true]", "[{}]"),
    "int[]": ('["1"]', "[1.5]", "[true]", "[null]", "[[1]]", f"[{'1' * 21}]", f"[{'1' * 5000}]"),
    "double[]": ('["1"]', "[true]", "[null]"),
    "bool[]": ("[0]", '["true"]', "[null]"),
    "Component_Status[]": ('["FINE"]', "[0]"),
    "int[][]": ("[1]", "[[1], 2]", '[["1"]]'),
    "int" + "[]" * 9: ("[" * 9 + "]" * 9,),
}


def emit() -> str:
    """Return the file's text: one case on each line."""
    valid = [_line({"type": code, "text": text, "value": value}) for code, text, value in _valid()]
    invalid = [_line({"type": code, "text": text}) for code, text in _invalid()]
    return f'{{"valid": [\n{_joined(valid)}\n],\n"invalid": [\n{_joined(invalid)}\n]}}\n'


def _valid() -> Iterator[tuple[str, str, Any]]:
    for codes, values in (
        (("int", "Integer", "long", "SHORT"), _INTEGERS),
        (("double", "Float"), _NUMBERS),
        (("bool", "Boolean"), _TRUTHS),
        (("string", "String", "RoISIdentifier", "Something_Else"), {text: text for text in _TEXTS}),
        (("Component_Status",), {"READY": "READY", "UNINITIALIZED": "UNINITIALIZED"}),
        (("Stream_Status",), {"STREAMING_RUNNING": "STREAMING_RUNNING", "of another version": "of another version"}),
        (("DateTime",), {"2026-11-21T12:00:00.000001+09:00": "2026-11-21T12:00:00.000001+09:00"}),
    ):
        yield from ((code, text, value) for code in codes for text, value in values.items())
    yield from ((code, text, json.loads(text)) for code, texts in _LISTS.items() for text in texts)


def _invalid() -> Iterator[tuple[str, str]]:
    for codes, texts in (
        (("int", "Integer", "long", "SHORT"), _NO_INTEGERS),
        (("double", "Float"), (*_NO_NUMBERS, "1.", ".5", "1e", "1e999", "1" * 41)),
        (("bool", "Boolean"), _NO_TRUTHS),
        (("Component_Status",), _NO_STATUS),
        (tuple(_LISTS), _NO_LISTS),
    ):
        yield from ((code, text) for code in codes for text in texts)
    yield from ((code, text) for code, texts in _WRONG_LISTS.items() for text in texts)


def _line(case: Mapping[str, Any]) -> str:
    return json.dumps(case, ensure_ascii=False, separators=(",", ":"))


def _joined(lines: list[str]) -> str:
    return ",\n".join(lines)
