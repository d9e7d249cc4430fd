"""The sentence of a reason: the text of any exception becomes one line that can be shown."""

import pytest

from openrois.errors import BadParameter
from openrois.types.reasons import MAX_REASON, ReasonNotification, sentence


@pytest.mark.parametrize(
    ("told", "line"),
    [
        ("set target_positions first", "set target_positions first"),
        (BadParameter("too loud"), "too loud"),
        ("  one\n\ttwo\x00three\x1b[31m ", "one two three [31m"),
        ("\u202egnp.exe\ud800", "gnp.exe"),
        ("日本語で話す", "日本語で話す"),
        ("", ""),
        ("\n \x07", ""),
        (ValueError(), ""),
    ],
)
def test_one_line(told: object, line: str) -> None:
    assert sentence(told) == line


@pytest.mark.parametrize("character", ["x", "日", "x ", "\n"])
def test_what_is_long_is_cut(character: str) -> None:
    assert len(sentence(character * 1_000_000)) <= MAX_REASON
    assert sentence("x" * MAX_REASON) == "x" * MAX_REASON
    assert sentence("x" * (MAX_REASON + 1)).endswith("x…")


def test_what_it_makes_of_anything_is_a_reason() -> None:
    everything = "".join(map(chr, range(0, 0x110000, 7)))
    for start in range(0, len(everything), 300):
        line = sentence(everything[start : start + 600])
        assert line.isprintable()
        if line:
            assert ReasonNotification(command_id="c", reason=line).reason == line
